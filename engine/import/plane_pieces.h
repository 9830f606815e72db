// Convex pieces of plane regions in space: the bridge between rings of mesh vertices and the plane.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/geometry.h"
#include "engine/import/convex_pieces.h"

namespace atrium {

// Projects rings of vertices onto a plane's frame, every vertex once.
struct PlaneRings {
  std::vector<Vec2> points;
  std::vector<std::uint32_t> vertices;  // of points
  std::vector<Ring> rings;              // indices of points
};
PlaneRings project(std::span<const Vec3> vertices, std::span<const Ring> rings, const Frame& frame);

// A frame of the plane that keeps coordinates small: its origin at the ring's first vertex.
Frame frame_for(const Plane& plane, PolygonView polygon);

// Convex pieces of the region that rings of vertices bound; opposite edges cancel. Corners are the
// rings' own vertices; where a cut ends inside an edge a vertex is appended. Nothing if the rings
// cross or the area is not kept.
std::optional<std::vector<Ring>> convex_pieces_in_space(std::vector<Vec3>& vertices,
                                                        std::span<const Ring> rings,
                                                        const Frame& frame, double tolerance,
                                                        double area_slack);

}  // namespace atrium
