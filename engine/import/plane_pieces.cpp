#include "engine/import/plane_pieces.h"

#include <unordered_map>

namespace atrium {

PlaneRings project(std::span<const Vec3> vertices, std::span<const Ring> rings,
                   const Frame& frame) {
  PlaneRings out;
  std::unordered_map<std::uint32_t, std::uint32_t> numbers;
  for (const Ring& ring : rings) {
    Ring& local = out.rings.emplace_back();
    for (const std::uint32_t v : ring) {
      const auto [at, added] =
          numbers.try_emplace(v, static_cast<std::uint32_t>(out.points.size()));
      if (added) {
        out.points.push_back(frame.to_plane(vertices[v]));
        out.vertices.push_back(v);
      }
      local.push_back(at->second);
    }
  }
  return out;
}

Frame frame_for(const Plane& plane, PolygonView polygon) {
  Frame f;
  f.n = plane.normal;
  f.origin = polygon[0] - plane.distance(polygon[0]) * plane.normal;
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(f.n[k]) < std::abs(f.n[least])) least = k;
  Vec3 axis{0};
  axis[least] = 1;
  f.u = normalize(cross(f.n, axis));
  f.v = cross(f.n, f.u);
  return f;
}

std::optional<std::vector<Ring>> convex_pieces_in_space(std::vector<Vec3>& vertices,
                                                        std::span<const Ring> rings,
                                                        const Frame& frame, double tolerance,
                                                        double area_slack) {
  PlaneRings flat = project(vertices, rings, frame);
  const std::vector<Ring> loops = cancelled_loops(flat.points, flat.rings);
  std::optional<std::vector<Ring>> pieces =
      convex_pieces(flat.points, loops, tolerance, area_slack);
  if (!pieces) return std::nullopt;
  for (std::size_t i = flat.vertices.size(); i < flat.points.size(); ++i) {
    flat.vertices.push_back(static_cast<std::uint32_t>(vertices.size()));
    vertices.push_back(frame.to_space(flat.points[i]));
  }
  for (Ring& piece : *pieces)
    for (std::uint32_t& corner : piece) corner = flat.vertices[corner];
  return pieces;
}

}  // namespace atrium
