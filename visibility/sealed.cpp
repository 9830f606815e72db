#include "visibility/sealed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <optional>
#include <utility>

#include "engine/disjoint_sets.h"
#include "visibility/bsp.h"

namespace atrium {

namespace {

// Import welds vertices: what is one point has one set of bits.
using Point = std::array<double, 3>;
using Edge = std::pair<Point, Point>;

Point point_of(const Vec3& x) { return {x.x, x.y, x.z}; }
Edge edge_of(const Vec3& a, const Vec3& b) { return std::minmax(point_of(a), point_of(b)); }
Vec3 vec_of(const Point& p) { return {p[0], p[1], p[2]}; }

// Surfaces that edges join, and the edges that only one of them has.
struct Shell {
  std::vector<std::uint32_t> surfaces;
  std::vector<Edge> rim;
  bool branches = false;  // an edge is of three surfaces or more
};

std::vector<Shell> shells_of(const Scene& scene, std::span<const std::uint32_t> surfaces) {
  std::map<Edge, std::vector<std::uint32_t>> at;  // places in `surfaces`
  for (std::uint32_t i = 0; i < surfaces.size(); ++i) {
    const PolygonView polygon = scene.polygon(scene.surfaces[surfaces[i]]);
    for (std::size_t k = 0; k < polygon.size(); ++k)
      at[edge_of(polygon[k], polygon[(k + 1) % polygon.size()])].push_back(i);
  }
  DisjointSets sets(surfaces.size());
  for (const auto& [edge, of] : at)
    for (const std::uint32_t i : of) sets.join(of.front(), i);
  std::map<std::uint32_t, Shell> by_first;
  for (std::uint32_t i = 0; i < surfaces.size(); ++i)
    by_first[std::uint32_t(sets.find(i))].surfaces.push_back(surfaces[i]);
  for (const auto& [edge, of] : at) {
    Shell& shell = by_first[std::uint32_t(sets.find(of.front()))];
    if (of.size() == 1) shell.rim.push_back(edge);
    shell.branches |= of.size() > 2;
  }
  std::vector<Shell> shells;
  for (auto& [first, shell] : by_first) shells.push_back(std::move(shell));
  return shells;
}

// The plane, turned so that all points are behind it, some of them clearly; none: both sides have
// some, or neither.
std::optional<Plane> outwards(const Plane& plane, PolygonView points, double tolerance) {
  double least = 0, most = 0;
  for (const Vec3& x : points) {
    least = std::min(least, plane.distance(x));
    most = std::max(most, plane.distance(x));
  }
  if (least >= -tolerance && most > 2 * tolerance) return plane.flipped();
  if (most <= tolerance && least < -2 * tolerance) return plane;
  return {};
}

// The rim as closed lines; none: an edge leads nowhere.
std::optional<std::vector<Polygon>> loops_of(std::vector<Edge> rim) {
  std::vector<Polygon> loops;
  while (!rim.empty()) {
    const auto [start, second] = rim.back();
    rim.pop_back();
    Polygon& loop = loops.emplace_back(Polygon{vec_of(start)});
    for (Point at = second; at != start;) {
      loop.push_back(vec_of(at));
      const auto next = std::ranges::find_if(
          rim, [&](const Edge& e) { return e.first == at || e.second == at; });
      if (next == rim.end()) return {};
      at = next->first == at ? next->second : next->first;
      rim.erase(next);
    }
  }
  return loops;
}

// Of the solid's planes the one through what all of a loop of its rim lies on, with the shell on
// one side of it; none: it stands on nothing, or not with all of it.
std::optional<Plane> closed_by(const Scene& scene, const BoxTree& surfaces, const Polygon& loop,
                               PolygonView points) {
  if (loop.size() < 3 || !is_convex(loop, scene.tolerance)) return {};
  std::optional<Plane> found;
  surfaces.visit(bounds(loop), [&](std::uint32_t s) {
    const PolygonView under = scene.polygon(scene.surfaces[s]);
    const Plane plane = plane_of(under);
    const auto lies_on = [&](const Vec3& x) {
      return std::abs(plane.distance(x)) <= scene.tolerance &&
             contains(under, plane.normal, x, scene.tolerance);
    };
    if (!found && std::ranges::all_of(loop, lies_on))
      found = outwards(plane, points, scene.tolerance);
  });
  return found;
}

// The planes that bound it, outwards; none: it is not sealed.
std::vector<Plane> planes_of(const Scene& scene, const BoxTree& surfaces, const Shell& shell,
                             PolygonView points) {
  if (shell.branches) return {};
  std::vector<Plane> planes;
  const auto add = [&](const std::optional<Plane>& plane) {
    if (plane) planes.push_back(*plane);
    return plane.has_value();
  };
  for (const std::uint32_t s : shell.surfaces)
    if (!add(outwards(plane_of(scene.polygon(scene.surfaces[s])), points, scene.tolerance)))
      return {};
  const auto loops = loops_of(shell.rim);  // last: few shells are convex, and rims may be long
  if (!loops) return {};
  for (const Polygon& loop : *loops)
    if (!add(closed_by(scene, surfaces, loop, points))) return {};
  constexpr std::size_t kFewest = 4;  // that enclose a volume
  return planes.size() < kFewest ? std::vector<Plane>{} : planes;
}

bool lamp_at(const Scene& scene, const BoxTree& surfaces, Box box) {
  box.lo -= Vec3{scene.tolerance};
  box.hi += Vec3{scene.tolerance};
  bool lamp = false;
  surfaces.visit(box, [&](std::uint32_t s) {
    lamp |= scene.materials[scene.surfaces[s].material.value].emits();
  });
  return lamp;
}

bool within(std::span<const Plane> planes, const Vec3& x, double margin) {
  return std::ranges::all_of(planes,
                             [&](const Plane& p) { return p.distance(x) <= margin; });
}

}  // namespace

SealedSolids::SealedSolids(const Scene& scene, const BoxTree& surfaces,
                           std::span<const std::vector<std::uint32_t>> of_object)
    : boxes_({}), tolerance_(kSliverTolerances * scene.tolerance) {
  std::vector<Box> boxes;
  for (const std::vector<std::uint32_t>& own : of_object)
    for (const Shell& shell : shells_of(scene, own)) {
      Polygon points;
      for (const std::uint32_t s : shell.surfaces)
        std::ranges::copy(scene.polygon(scene.surfaces[s]), std::back_inserter(points));
      std::vector<Plane> planes = planes_of(scene, surfaces, shell, points);
      const Box box = bounds(points);
      if (planes.empty() || lamp_at(scene, surfaces, box)) continue;
      solids_.push_back(std::move(planes));
      boxes.push_back(box);
    }
  boxes_ = BoxTree(std::move(boxes));
}

bool SealedSolids::darken(PolygonView polygon) const {
  constexpr double kBefore = 2;  // tolerances: clearly on this side of what it lies on
  const Vec3 before = centroid(polygon) + kBefore * tolerance_ * plane_of(polygon).normal;
  bool dark = false;
  boxes_.visit(Box{before, before}, [&](std::uint32_t i) {
    const std::span<const Plane> planes = solids_[i];
    dark = dark || (within(planes, before, -0.5 * kBefore * tolerance_) &&
                    std::ranges::all_of(polygon, [&](const Vec3& x) {
                      return within(planes, x, tolerance_);
                    }));
  });
  return dark;
}

}  // namespace atrium
