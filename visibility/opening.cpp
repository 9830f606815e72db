#include "visibility/opening.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "engine/disjoint_sets.h"
#include "visibility/grid_paths.h"

namespace atrium {

namespace {

// Sines of angles between planes below this are none.
constexpr double kSamePlane = 1e-6;
// A grid step is this share of the tolerance.
constexpr double kGridOfTolerance = 0.1;
// A width is found to this share of itself.
constexpr double kWidthShare = 1e-3;
// The objects around an opening come this near to its rim: a share of its width, and tolerances.
constexpr double kNearWidths = 0.25, kNearTolerances = 10;
// Places along a rim's side at which objects are looked for.
constexpr int kRimPlaces = 8;
// Where along a shared side the spaces beside it are tried for being joined.
constexpr double kTries[] = {0.1, 0.5, 0.9};

// Calls meet(x) with points of the sides that two polygons of one plane share, until it says true.
template <class Meet>
bool any_shared_point(PolygonView p, PolygonView q, double tolerance, Meet&& meet) {
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Vec3 a = p[i], edge = p[(i + 1) % p.size()] - a;
    const double l = length(edge);
    if (!(l > tolerance)) continue;
    const Vec3 u = edge / l;
    for (std::size_t j = 0; j < q.size(); ++j) {
      const Vec3 c = q[j] - a, d = q[(j + 1) % q.size()] - a;
      if (length(c - dot(c, u) * u) > tolerance || length(d - dot(d, u) * u) > tolerance) continue;
      const double from = std::max(0.0, std::min(dot(c, u), dot(d, u)));
      const double to = std::min(l, std::max(dot(c, u), dot(d, u)));
      if (to - from <= tolerance) continue;
      for (double share : kTries)
        if (meet(a + (from + share * (to - from)) * u)) return true;
    }
  }
  return false;
}

// One opening on its plane's grid.
class Region {
 public:
  Region(const Bsp& bsp, const std::vector<CellPortal>& portals,
         const std::vector<std::uint32_t>& group)
      : portals_(portals), group_(group) {
    std::vector<Polygon> polygons;
    for (std::uint32_t i : group) polygons.push_back(portals[i].polygon);
    const PlaneGrid grid{frame_of(polygons.front()), kGridOfTolerance * bsp.tolerance};
    region_ = union_of(grid, polygons, kSliverTolerances * bsp.tolerance);
    sliver_ = kSliverTolerances / kGridOfTolerance;
  }

  double unit() const { return region_.grid.unit; }
  // Where a ball of the radius passes, in grid steps, and what lies within `beyond` of there.
  GridPaths passed(double radius, double beyond) const {
    const GridPaths centers = offset(region_.loops, -radius);
    return centers.empty() ? centers : offset(centers, radius + beyond);
  }

  void mark(const GridPaths& passed, std::vector<bool>& portals) const {
    if (passed.empty()) return;
    for (std::uint32_t i : group_) portals[i] = !common(i, passed).empty();
  }

  void add_narrow(double radius, std::vector<NarrowOpening>& out) const {
    for (const GridPaths& part :
         combine(region_.loops, passed(radius, radius), Combine::kDifference)) {
      NarrowOpening opening = measured(part, radius);
      if (!(opening.width > sliver_ * unit())) continue;
      for (std::uint32_t i : group_)
        if (!common(i, part).empty()) opening.portals.push_back(i);
      if (!opening.portals.empty()) out.push_back(std::move(opening));
    }
  }

 private:
  // What a portal has of a part, but for strips along its rim.
  GridPaths common(std::uint32_t portal, const GridPaths& part) const {
    const GridPath path = to_path(region_.grid, portals_[portal].polygon);
    GridPaths both;
    for (const GridPaths& piece : combine({path}, part, Combine::kIntersection))
      both.insert(both.end(), piece.begin(), piece.end());
    return offset(both, -0.5 * sliver_);
  }

  NarrowOpening measured(const GridPaths& part, double most) const {
    double fits = 0, fails = most;
    GridPaths middle = part;
    while (fails - fits > std::max(kWidthShare * fails, 0.5)) {
      const double radius = 0.5 * (fits + fails);
      GridPaths centers = offset(part, -radius);
      (centers.empty() ? fails : fits) = radius;
      if (!centers.empty()) middle = std::move(centers);
    }
    NarrowOpening opening;
    opening.width = 2 * fits * unit();
    if (!(opening.width > 0)) return opening;
    opening.length = area_of(part) * unit() * unit() / opening.width;
    opening.widest = center(middle.front());
    for (const GridPath& loop : part) opening.outline.push_back(to_polygon(region_.grid, loop));
    opening.along = longest_side(opening.outline);
    return opening;
  }

  Vec3 center(const GridPath& path) const {
    const Polygon polygon = to_polygon(region_.grid, path);
    return std::accumulate(polygon.begin(), polygon.end(), Vec3{0}) / double(polygon.size());
  }

  static Vec3 longest_side(const std::vector<Polygon>& loops) {
    Vec3 longest{0};
    for (const Polygon& loop : loops)
      for (std::size_t i = 0; i < loop.size(); ++i) {
        const Vec3 side = loop[(i + 1) % loop.size()] - loop[i];
        if (length(side) > length(longest)) longest = side;
      }
    return normalize(longest);
  }

  const std::vector<CellPortal>& portals_;
  const std::vector<std::uint32_t>& group_;
  PlaneRegion region_;
  double sliver_ = 0;  // grid steps
};

}  // namespace

Joints::Joints(const std::vector<CellPortal>& portals) : portals_(portals) {
  for (std::uint32_t i = 0; i < portals.size(); ++i)
    rows_[std::minmax(portals[i].front, portals[i].back)].push_back(i);
}

bool Joints::joined(std::uint32_t a, std::uint32_t b, const Vec3& x, double tolerance) const {
  if (a == b) return true;
  const auto row = rows_.find(std::minmax(a, b));
  if (row == rows_.end()) return false;
  return std::any_of(row->second.begin(), row->second.end(), [&](std::uint32_t i) {
    const Plane plane = plane_of(portals_[i].polygon);
    return std::abs(plane.distance(x)) <= tolerance &&
           contains(portals_[i].polygon, plane.normal, x, tolerance);
  });
}

bool one_opening(const CellPortal& p, const CellPortal& q, const Joints& joints, double tolerance) {
  const Plane plane = plane_of(p.polygon);
  const Vec3 other = plane_of(q.polygon).normal;
  if (length(cross(plane.normal, other)) > kSamePlane) return false;
  for (const Vec3& x : q.polygon)
    if (std::abs(plane.distance(x)) > tolerance) return false;
  const bool along = dot(plane.normal, other) > 0;
  const std::uint32_t q_front = along ? q.front : q.back, q_back = along ? q.back : q.front;
  return any_shared_point(p.polygon, q.polygon, tolerance, [&](const Vec3& x) {
    return joints.joined(p.front, q_front, x, tolerance) &&
           joints.joined(p.back, q_back, x, tolerance);
  });
}

Rows32 group_portals(const Bsp& bsp, const std::vector<CellPortal>& portals) {
  const double tolerance = kSliverTolerances * bsp.tolerance;
  std::vector<Box> boxes;
  for (const CellPortal& p : portals) {
    Box box = bounds(p.polygon);
    box.lo -= Vec3{tolerance};
    box.hi += Vec3{tolerance};
    boxes.push_back(box);
  }
  const BoxTree tree(boxes);
  const Joints joints(portals);
  DisjointSets sets(portals.size());
  for (std::uint32_t i = 0; i < portals.size(); ++i)
    tree.visit(boxes[i], [&](std::uint32_t j) {
      if (j > i && sets.find(i) != sets.find(j) &&
          one_opening(portals[i], portals[j], joints, tolerance))
        sets.join(i, j);
    });
  std::map<std::size_t, std::vector<std::uint32_t>> groups;
  for (std::uint32_t i = 0; i < portals.size(); ++i) groups[sets.find(i)].push_back(i);
  Rows32 rows;
  for (auto& [set, row] : groups) rows.push_back(std::move(row));
  return rows;
}

std::vector<bool> passable(const Bsp& bsp, const std::vector<CellPortal>& portals,
                           const Rows32& groups, double size) {
  std::vector<bool> wide(portals.size(), false);
  for (const auto& group : groups) {
    const Region region(bsp, portals, group);
    region.mark(region.passed(0.5 * size / region.unit(), 0), wide);
  }
  return wide;
}

Openings find_openings(const Bsp& bsp, const std::vector<CellPortal>& portals, const Rows32& groups,
                       double size) {
  Openings found{passable(bsp, portals, groups, size), {}};
  for (const auto& group : groups) {
    const Region region(bsp, portals, group);
    region.add_narrow(0.5 * size / region.unit(), found.narrow);
  }
  return found;
}

std::vector<ObjectId> objects_around(const Scene& scene, const BoxTree& tree,
                                     const NarrowOpening& opening) {
  const double near = std::max(kNearWidths * opening.width, kNearTolerances * scene.tolerance);
  std::map<ObjectId, double> rim;
  for (const Polygon& loop : opening.outline)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vec3 a = loop[i], side = loop[(i + 1) % loop.size()] - a;
      for (int k = 0; k < kRimPlaces; ++k) {
        const Vec3 x = a + (k + 0.5) / kRimPlaces * side;
        std::set<ObjectId> here;
        tree.visit({x - Vec3{near}, x + Vec3{near}}, [&](std::uint32_t s) {
          const Surface& surface = scene.surfaces[s];
          if (!here.contains(surface.object) && distance_to(scene.polygon(surface), x) <= near)
            here.insert(surface.object);
        });
        for (ObjectId object : here) rim[object] += length(side) / kRimPlaces;
      }
    }
  std::vector<std::pair<ObjectId, double>> rows(rim.begin(), rim.end());
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<ObjectId> objects;
  for (const auto& [object, length_of_rim] : rows) objects.push_back(object);
  return objects;
}

}  // namespace atrium
