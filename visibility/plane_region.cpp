#include "visibility/plane_region.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "visibility/convex_hull.h"
#include "visibility/grid_paths.h"

namespace atrium {

namespace {

// A hull serves as one portal where it is at most this much larger than what it stands for.
// [facts: visibility, step 3]
constexpr double kHullSlack = 1.3;
// Lines tried for a cut, longest edges first.
constexpr std::size_t kCutsTried = 8;
// Cuts of one region in depth; past it a hull serves whatever its size.
constexpr int kDeepestCut = 12;

struct GridBox {
  std::int64_t x0 = INT64_MAX, y0 = INT64_MAX, x1 = INT64_MIN, y1 = INT64_MIN;
  void extend(std::int64_t x, std::int64_t y) {
    x0 = std::min(x0, x), x1 = std::max(x1, x);
    y0 = std::min(y0, y), y1 = std::max(y1, y);
  }
  bool overlaps(const GridBox& b) const {
    return x0 <= b.x1 && b.x0 <= x1 && y0 <= b.y1 && b.y0 <= y1;
  }
};

GridBox box_of(const GridPath& path) {
  GridBox box;
  for (const auto& p : path) box.extend(p.x, p.y);
  return box;
}

double turn(const GridPoint& a, const GridPoint& b, const GridPoint& c) {
  return double(b.x - a.x) * double(c.y - a.y) - double(b.y - a.y) * double(c.x - a.x);
}

GridPath hull(const GridPath& points) {
  return convex_hull(points, std::identity(),
                     [](const auto& a, const auto& b, const auto& c) { return turn(a, b, c); });
}

// An outer loop and its holes.
using Component = GridPaths;

struct Edge {
  GridPoint a, b;
  double squared_length = 0;
};

// Edges of the component that run through its hull's inside, longest first.
std::vector<Edge> inner_edges(const Component& component, const GridPath& outline) {
  std::vector<Edge> edges;
  for (const GridPath& loop : component)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const auto &a = loop[i], &b = loop[(i + 1) % loop.size()];
      const bool inside = std::any_of(outline.begin(), outline.end(),
                                      [&](const GridPoint& p) { return turn(a, b, p) > 0; }) &&
                          std::any_of(outline.begin(), outline.end(),
                                      [&](const GridPoint& p) { return turn(a, b, p) < 0; });
      if (!inside) continue;
      const double dx = double(b.x - a.x), dy = double(b.y - a.y);
      edges.push_back({a, b, dx * dx + dy * dy});
    }
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.squared_length > b.squared_length;
  });
  if (edges.size() > kCutsTried) edges.resize(kCutsTried);
  return edges;
}

// The half of a box that contains the component, left or right of the edge's line.
GridPath half_plane(const Edge& edge, const GridBox& box, double side) {
  const double l = std::sqrt(edge.squared_length);
  const double ux = double(edge.b.x - edge.a.x) / l, uy = double(edge.b.y - edge.a.y) / l;
  const double reach = 2 * std::hypot(double(box.x1 - box.x0), double(box.y1 - box.y0)) + 2;
  const double nx = -uy * side, ny = ux * side;
  auto at = [&](double along, double across) {
    return GridPoint{std::llround(double(edge.a.x) + along * ux + across * nx),
                     std::llround(double(edge.a.y) + along * uy + across * ny)};
  };
  GridPath path{at(-reach, 0), at(reach, 0), at(reach, reach), at(-reach, reach)};
  make_counter_clockwise(path);
  return path;
}

std::vector<Component> cut(const Component& component, const Edge& edge) {
  const GridBox box = box_of(component.front());
  std::vector<Component> parts;
  for (double side : {1.0, -1.0})
    for (Component& part :
         combine(component, {half_plane(edge, box, side)}, Combine::kIntersection))
      parts.push_back(std::move(part));
  return parts;
}

double hull_area(const std::vector<Component>& parts) {
  double sum = 0;
  for (const Component& part : parts) sum += area_of(hull(part.front()));
  return sum;
}

double grid_width(const GridPath& path, double area) {
  double perimeter = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto &a = path[i], &b = path[(i + 1) % path.size()];
    perimeter += std::hypot(double(b.x - a.x), double(b.y - a.y));
  }
  return perimeter > 0 ? 2 * area / perimeter : 0;
}

void convex_pieces(const Component& component, const PlaneGrid& grid, double sliver, int depth,
                   std::vector<OpenPiece>& out) {
  const double open = area_of(component);
  if (grid_width(component.front(), open) * grid.unit < sliver) return;
  const GridPath outline = hull(component.front());
  if (outline.size() < 3) return;
  const std::vector<Edge> edges = depth < kDeepestCut && area_of(outline) > kHullSlack * open
                                      ? inner_edges(component, outline)
                                      : std::vector<Edge>{};
  if (edges.empty()) {
    out.push_back({to_polygon(grid, outline), open * grid.unit * grid.unit});
    return;
  }
  std::vector<Component> best;
  double least = 0;
  for (const Edge& edge : edges) {
    std::vector<Component> parts = cut(component, edge);
    const double covered = hull_area(parts);
    if (best.empty() || covered < least) best = std::move(parts), least = covered;
  }
  for (const Component& part : best) convex_pieces(part, grid, sliver, depth + 1, out);
}

GridPaths overlapping_loops(const PlaneRegion& region, const GridBox& box) {
  GridPaths paths;
  for (const auto& loop : region.loops)
    if (box_of(loop).overlaps(box)) paths.push_back(loop);
  return paths;
}

}  // namespace

GridPoint PlaneGrid::to_grid(const Vec3& x) const {
  const Vec2 p = frame.to_plane(x);
  return {std::llround(p.x / unit), std::llround(p.y / unit)};
}

Vec3 PlaneGrid::to_space(const GridPoint& p) const {
  return frame.to_space({double(p.x) * unit, double(p.y) * unit});
}

double strip_width(PolygonView polygon) {
  double perimeter = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    perimeter += length(polygon[(i + 1) % polygon.size()] - polygon[i]);
  return perimeter > 0 ? 2 * area(polygon) / perimeter : 0;
}

PlaneRegion union_of(const PlaneGrid& grid, std::span<const Polygon> polygons, double gap) {
  GridPaths paths;
  paths.reserve(polygons.size());
  for (const Polygon& polygon : polygons) {
    GridPath path = to_path(grid, polygon);
    if (area_of(path) > 0) paths.push_back(std::move(path));
  }
  const double half_gap = 0.5 * gap / grid.unit;
  return {grid, offset(offset(paths, half_gap), -half_gap)};
}

std::vector<OpenPiece> open_pieces(const PlaneRegion& opaque, PolygonView footprint,
                                   double sliver) {
  if (footprint.size() < 3 || strip_width(footprint) < sliver) return {};
  const GridPath path = to_path(opaque.grid, footprint);
  const GridPaths walls = overlapping_loops(opaque, box_of(path));
  if (walls.empty()) return {{Polygon(footprint.begin(), footprint.end()), area(footprint)}};
  // Strips along the walls go by shrinking and growing again, one step more than was lost.
  const double half = 0.5 * sliver / opaque.grid.unit;
  GridPaths open;
  for (Component& component : combine({path}, walls, Combine::kDifference))
    open.insert(open.end(), component.begin(), component.end());
  open = offset(offset(open, -half), half + 1);
  std::vector<OpenPiece> pieces;
  for (const Component& component : combine(open, {}, Combine::kUnion))
    convex_pieces(component, opaque.grid, sliver, 0, pieces);
  return pieces;
}

bool contains(const PlaneRegion& region, const Vec3& x) {
  const Vec2 p = region.grid.frame.to_plane(x) / region.grid.unit;
  bool inside = false;
  for (const auto& loop : region.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const GridPoint &g = loop[i], &h = loop[(i + 1) % loop.size()];
      if ((double(g.y) > p.y) == (double(h.y) > p.y)) continue;
      const double t = (p.y - double(g.y)) / double(h.y - g.y);
      inside ^= double(g.x) + t * double(h.x - g.x) > p.x;
    }
  return inside;
}

double covered_length(const PlaneRegion& region, const Vec3& a, const Vec3& b) {
  const Vec2 p = region.grid.frame.to_plane(a) / region.grid.unit;
  const Vec2 q = region.grid.frame.to_plane(b) / region.grid.unit;
  const Vec2 d = q - p;
  // Where the segment crosses a loop it enters or leaves: even-odd along the line from p.
  std::vector<double> crossings;
  for (const auto& loop : region.loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const GridPoint &g = loop[i], &h = loop[(i + 1) % loop.size()];
      const double sg = d.x * (double(g.y) - p.y) - d.y * (double(g.x) - p.x);
      const double sh = d.x * (double(h.y) - p.y) - d.y * (double(h.x) - p.x);
      if ((sg > 0) == (sh > 0)) continue;
      const double t = sg / (sg - sh);
      const Vec2 x{double(g.x) + t * double(h.x - g.x), double(g.y) + t * double(h.y - g.y)};
      crossings.push_back(glm::dot(x - p, d) / glm::dot(d, d));
    }
  std::sort(crossings.begin(), crossings.end());
  double share = 0;
  for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
    share += std::max(0.0, std::min(1.0, crossings[i + 1]) - std::max(0.0, crossings[i]));
  return share * length(b - a);
}

}  // namespace atrium
