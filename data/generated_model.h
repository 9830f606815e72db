// GeneratedModel: named groups of planar convex faces, as a modeller leaves them.
//
// Invariants:
//  1. Group g holds faces[g.first_face .. g.first_face + g.face_count), at least one; groups are
//     contiguous and in the modeller's order. Names are unique.
//  2. Face f holds vertices[f.first_vertex .. + f.vertex_count), counter-clockwise from the air.
// Plain data; safe to read from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry.h"
#include "engine/spectrum.h"

namespace atrium {

struct Paint {
  std::string name;
  Spectrum reflectance{0};
  Spectrum luminance{0};  // cd/m²
  bool emits() const { return luminance != Spectrum{0}; }
};

using PaintId = std::uint32_t;  // into GeneratedModel::paints

struct GeneratedFace {
  PaintId paint = 0;
  std::uint32_t first_vertex = 0, vertex_count = 0;
};

struct GeneratedGroup {  // a cluster
  std::string name;
  std::uint32_t first_face = 0, face_count = 0;
};

struct ModelCounts {
  std::uint64_t clusters = 0, patches = 0, lights = 0;
};

struct GeneratedModel {
  std::string title;
  std::vector<Paint> paints;
  std::vector<GeneratedGroup> groups;
  std::vector<GeneratedFace> faces;
  std::vector<Vec3> vertices;

  PolygonView polygon(const GeneratedFace& f) const {
    return std::span(vertices).subspan(f.first_vertex, f.vertex_count);
  }
  ModelCounts counts() const;
};

}  // namespace atrium
