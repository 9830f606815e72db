// RawModel: what the readers find in the files, before anything is judged. Readers append to it,
// one file after another; indices run on, so that equal names in different files stay apart.
//
// Invariants: every corner is a valid index into `vertices`; every coordinate is finite; a face has
// corners, though perhaps too few. Not thread safe: one import fills one model.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/scene.h"
#include "engine/spectrum.h"
#include "engine/vec.h"

namespace atrium {

struct RawMaterial {
  std::string name;
  Spectrum reflectance{0};  // as written, where has_reflectance
  Spectrum emission{0};     // as written
  bool has_reflectance = false;
  bool emission_is_luminance = false;  // cd/m² whatever --emission says: it was assigned
  std::optional<Sides> sides;          // assigned
  double opacity = 1;                  // d, or alpha
  bool textured = false;
  bool double_sided = false;  // glTF's doubleSided
  std::uint32_t file = 0;     // index into RawModel::files
  std::string library;        // the file that defines it, "" if none does
  std::string place;          // where in it
};

struct RawObject {
  std::string name;
  std::uint32_t file = 0;
  std::string place_word;     // what RawFace::place counts: "line", "triangle"
  bool unnamed_file = false;  // its file names no objects: to be split into connected parts
};

struct RawFace {
  static constexpr std::uint32_t kNoMaterial = 0xffffffff;
  std::uint32_t first_corner = 0, corner_count = 0;
  std::uint32_t object = 0;
  std::uint32_t material = kNoMaterial;
  std::uint32_t place = 0;  // line in its file, or number in its mesh
};

struct RawModel {
  std::vector<std::string> files;
  std::vector<Vec3> vertices;  // in file units
  std::vector<std::uint32_t> corners;
  std::vector<RawFace> faces;
  std::vector<RawObject> objects;
  std::vector<RawMaterial> materials;

  std::span<const std::uint32_t> corners_of(const RawFace& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
  // "object 'desk', line 12": for warnings.
  std::string describe(const RawFace& f) const {
    const RawObject& o = objects[f.object];
    return "object '" + o.name + "', " + o.place_word + " " + std::to_string(f.place);
  }
};

}  // namespace atrium
