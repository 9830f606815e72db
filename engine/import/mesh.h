// Mesh: the scene's faces over welded vertices, between reading and rejoining.
//
// Invariants: vertices are metres in the scene's internal frame, no two of them are nearer than
// half the tolerance; every face is planar within the tolerance, simple, wider than it, and names
// no vertex twice; faces are in the files' order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry.h"
#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/scene.h"

namespace atrium {

// Of a region's area: what cutting and rejoining may change of it.
inline constexpr double kAreaSlack = 1e-6;

struct Face {
  std::uint32_t first_corner = 0, corner_count = 0;  // into Mesh::corners, counter-clockwise
  ObjectId object;
  MaterialId material;
  std::uint32_t raw = 0;  // the face of RawModel that it comes from
  std::uint8_t sides = kNoSide;
  Plane plane;
  double area = 0;  // m²
};

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::uint32_t> corners;
  std::vector<Face> faces;
  double tolerance = 0;  // metres

  std::span<const std::uint32_t> corners_of(const Face& f) const {
    return std::span(corners).subspan(f.first_corner, f.corner_count);
  }
  // The corners' positions, in the caller's scratch.
  PolygonView polygon(std::span<const std::uint32_t> ring, Polygon& scratch) const {
    scratch.clear();
    for (const std::uint32_t v : ring) scratch.push_back(vertices[v]);
    return scratch;
  }
};

// The width of a polygon: its area over its longest extent. Below the tolerance it is a line.
double width(PolygonView polygon);

// Welds the vertices of the faces `kept` and sorts out degenerate, duplicate and non-planar ones.
Mesh make_mesh(const RawModel& model, const std::vector<bool>& kept, const SceneFrame& frame,
               double tolerance, const std::vector<Material>& materials, WarningLog& warnings);

// Splits objects of files that name none into their connected parts, in the files' order.
void split_unnamed_objects(RawModel& model, Mesh& mesh);

}  // namespace atrium
