// Scene: what import makes of the files. Planar convex surfaces grouped into objects, materials
// with physical units, and everything that was found wrong, counted and named.
//
// Invariants:
//  1. Every surface is convex and planar within `tolerance`, and has area.
//  2. On either side of any point at most one surface counts (coplanar overlaps are resolved:
//     front before back, then the emitter, then the first in the files).
//  3. Positions are metres relative to frame.origin; file units and offsets are gone.
// Immutable after import; safe to read from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry.h"
#include "engine/id.h"
#include "engine/spectrum.h"

namespace atrium {

struct Material {
  std::string name;
  Spectrum reflectance{0};  // each channel in [0, 1)
  Spectrum exitance{0};     // M, lm/m², of each emitting side
  bool emits() const { return exitance.x > 0 || exitance.y > 0 || exitance.z > 0; }
};

// Which sides of a surface receive, reflect and emit. The other side, where light reaches it, is
// opaque and black. Both sides always block.
enum Sides : std::uint8_t { kNoSide = 0, kFront = 1, kBack = 2, kBothSides = 3 };

struct Surface {
  ObjectId object;
  MaterialId material;
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::uint8_t sides = kFront;  // Sides that count here, after overlaps are resolved
};

// A group of the modelling hierarchy: the cluster as the modeller left it.
struct Object {
  std::string name;
  std::uint32_t file = 0;  // index into Scene::files
};

// Something wrong or noteworthy in the input.
struct Warning {
  std::string what;                   // "degenerate faces dropped", "white paint taken as 0.9", …
  std::uint64_t count = 0;
  std::vector<std::string> examples;  // the first few, by object and place
};

struct SceneFrame {
  Vec3 origin{0};   // metres, of the internal origin in the files' frame
  double unit = 1;  // metres a file unit
  Vec3 to_internal(const Vec3& file_point) const { return file_point * unit - origin; }
  Vec3 to_file(const Vec3& x) const { return (x + origin) / unit; }
};

struct Scene {
  std::vector<std::string> files;
  SceneFrame frame;
  std::vector<Material> materials;
  std::vector<Object> objects;  // in the files' order
  std::vector<Surface> surfaces;  // in the files' order
  std::vector<Vec3> vertices;
  std::uint64_t polygons = 0;   // faces in the files, before anything was dropped or rejoined
  std::uint64_t patches = 0;    // after rejoining coplanar pieces, before overlaps cut any
  std::uint64_t lights = 0;     // the emitting ones among them
  std::vector<Warning> warnings;
  std::vector<std::uint64_t> faces_of_material;  // polygons in the files, by material
  Box bounds;
  double tolerance = 0;  // metres; lengths below it mean nothing in this scene

  PolygonView polygon(const Surface& s) const {
    return std::span(vertices).subspan(s.first_vertex, s.vertex_count);
  }
};

// Lengths below this share of the scene's diagonal are noise of modelling and of rounding:
// 1e-5 m in a building of 60 m. [facts: 1e-7 to 1e-4 m made no difference there]
inline constexpr double kToleranceOfDiagonal = 1.5e-7;

}  // namespace atrium
