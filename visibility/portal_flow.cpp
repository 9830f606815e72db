#include "visibility/portal_flow.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "visibility/convex_hull.h"

namespace atrium {

namespace {

// Noise that a separating plane may show at the polygons it separates, in tolerances.
constexpr double kPlaneNoise = 1e-3;
// A window this close to its portal's area, or with this many corners, becomes the portal.
constexpr double kNearlyAll = 0.9;
constexpr std::size_t kMostCorners = 12;

// The plane through the window's edge from a to b that touches the source, which lies behind the
// window's plane, and has the source on one side and the window on the other; nothing where the
// source reaches up to the window's plane beside the edge. Seen along the edge the window is the
// ray of `inward`, and the point of the source that is seen most steeply through the edge the one
// that lies farthest round towards it.
std::optional<Plane> plane_at_edge(const Vec3& a, const Vec3& b, const Vec3& passage,
                                   std::span<const Vec3> source, double noise) {
  const double l = length(b - a);
  if (!(l > noise)) return {};
  const Vec3 inward = cross(passage, b - a) / l;
  double x = 0, depth = 0;
  bool beyond = false, beside = false;
  for (const Vec3& s : source) {
    const double along = dot(s - a, inward), behind = -dot(s - a, passage);
    beside |= along > -noise;
    beyond |= behind < -noise;
    if (behind <= noise) {
      if (along > -noise) return {};
    } else if (depth == 0 || along * depth > x * behind) {
      x = along, depth = behind;
    }
  }
  if (depth == 0 || (beyond && beside)) return {};
  const Vec3 normal = (depth * inward + x * passage) / std::sqrt(x * x + depth * depth);
  return Plane{normal, dot(normal, a)};
}

// Each plane has the source behind it and the window before it: what is seen through the window
// lies before it too. Those through the window's edges; the ones through the source's edges would
// bound corners of what is seen and cost three times as much. [facts: visibility, step 4]
void separating_planes(std::span<const Vec3> source, PolygonView window, const Vec3& passage,
                       double noise, std::vector<Plane>& out) {
  for (std::size_t i = 0; i < window.size(); ++i)
    if (const auto plane =
            plane_at_edge(window[i], window[(i + 1) % window.size()], passage, source, noise))
      out.push_back(*plane);
}

// Leaves of the polygon what lies before the plane, a tolerance to spare; nothing if all of it that
// does is within tolerance of the plane.
void keep_seen(Polygon& polygon, const Plane& plane, double tolerance, Polygon& scratch) {
  bool cut = false, any = false;
  for (const Vec3& x : polygon) {
    const double d = plane.distance(x);
    cut |= d < -tolerance;
    any |= d > tolerance;
  }
  if (!any) return polygon.clear();
  if (!cut) return;
  scratch.clear();
  const double offset = plane.offset - tolerance;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &a = polygon[i], &b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
    const double da = dot(plane.normal, a) - offset, db = dot(plane.normal, b) - offset;
    if (da >= 0) scratch.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) scratch.push_back(a + (b - a) * (da / (da - db)));
  }
  std::swap(polygon, scratch);
}

// The convex hull of points in one plane, counter-clockwise about its normal.
Polygon hull_in_plane(PolygonView points, const Vec3& normal) {
  const Vec3 steep = std::abs(normal.x) > 0.5 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  const Vec3 u = normalize(cross(steep, normal)), v = cross(normal, u);
  struct Flat {
    Vec2 p;
    std::size_t index;
  };
  std::vector<Flat> flat;
  for (std::size_t i = 0; i < points.size(); ++i)
    flat.push_back({{dot(points[i], u), dot(points[i], v)}, i});
  Polygon polygon;
  for (const Flat& f : convex_hull(std::move(flat), &Flat::p)) polygon.push_back(points[f.index]);
  return polygon;
}

}  // namespace

std::vector<Vec3> corners_of(const Frame& frame, const Box& box, double tolerance) {
  std::vector<Vec3> corners;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Vec3 x;
    bool again = false;  // a flat box has one corner where a full one has two
    for (int k = 0; k < 3; ++k) {
      const bool upper = corner >> k & 1u;
      again |= upper && box.hi[k] - box.lo[k] <= tolerance;
      x[k] = upper ? box.hi[k] : box.lo[k];
    }
    if (!again) corners.push_back(frame.to_space(x));
  }
  return corners;
}

PortalGraph make_graph(const Bsp& bsp, const std::vector<CellPortal>& portals) {
  PortalGraph graph;
  graph.tolerance = bsp.tolerance;
  graph.first_out.assign(bsp.cells.size() + 1, 0);
  for (const CellPortal& p : portals)
    for (std::uint32_t from : {p.front, p.back}) ++graph.first_out[from + 1];
  std::partial_sum(graph.first_out.begin(), graph.first_out.end(), graph.first_out.begin());
  const std::size_t n = 2 * portals.size();
  graph.portals.resize(n);
  for (auto* values : {&graph.x, &graph.y, &graph.z, &graph.radius}) values->resize(n);
  std::vector<std::uint32_t> next(graph.first_out.begin(), graph.first_out.end() - 1);
  auto add = [&](Polygon polygon, const Plane& plane, std::uint32_t from, std::uint32_t to) {
    const std::uint32_t i = next[from]++;
    const Vec3 center = centroid(polygon);
    graph.x[i] = center.x, graph.y[i] = center.y, graph.z[i] = center.z;
    for (const Vec3& x : polygon) graph.radius[i] = std::max(graph.radius[i], length(x - center));
    graph.portals[i] = {std::move(polygon), plane, from, to, 0};
    return i;
  };
  for (const CellPortal& p : portals) {
    const Plane plane = bsp.nodes[p.node].plane;
    const std::uint32_t i =
        add({p.polygon.rbegin(), p.polygon.rend()}, plane.flipped(), p.front, p.back);
    const std::uint32_t j = add(p.polygon, plane, p.back, p.front);
    graph.portals[i].twin = j;
    graph.portals[j].twin = i;
  }
  return graph;
}

PortalFlow::PortalFlow(const PortalGraph& graph) : graph_(graph), windows_(graph.portals.size()) {}

void PortalFlow::start(std::span<const Vec3> source, std::size_t most_steps) {
  source_.assign(source.begin(), source.end());
  center_ = Vec3{0};
  for (const Vec3& x : source_) center_ += x / double(source_.size());
  ++run_;
  steps_ = 0;
  most_steps_ = most_steps;
  flooded_ = false;
  reached_.clear();
  queue_.clear();
  planes_.clear();
  limits_ = {};
}

void PortalFlow::run(std::span<const Vec3> source, std::uint32_t cell, std::size_t most_steps) {
  start(source, most_steps);
  spread(cell, kNone);
  while (!queue_.empty()) expand_next();
}

bool PortalFlow::later(const Waiting& a, const Waiting& b) {
  return a.distance != b.distance ? a.distance > b.distance : a.portal > b.portal;
}

// Expands the nearest waiting portal.
std::uint32_t PortalFlow::expand_next() {
  std::pop_heap(queue_.begin(), queue_.end(), later);
  const std::uint32_t portal = queue_.back().portal;
  queue_.pop_back();
  windows_[portal].queued = false;
  ++windows_[portal].visits;
  bounding_planes(portal);
  spread(graph_.portals[portal].to, graph_.portals[portal].twin);
  windows_[portal].planes.assign(planes_.begin(), planes_.end());
  return portal;
}

// The planes that bound what is seen through a reached portal's window.
void PortalFlow::bounding_planes(std::uint32_t portal) {
  planes_.clear();
  const Plane& own = graph_.portals[portal].plane;
  if (!flooded_)
    separating_planes(source_, windows_[portal].polygon, own.normal, kPlaneNoise * graph_.tolerance,
                      planes_);
  planes_.push_back(own);
}

bool PortalFlow::behind(const Plane& plane) const {
  return std::any_of(source_.begin(), source_.end(),
                     [&](const Vec3& x) { return plane.distance(x) < -graph_.tolerance; });
}

void PortalFlow::spread(std::uint32_t cell, std::uint32_t entered) {
  find_reaching(cell);
  const std::uint32_t first = graph_.first_out[cell], last = graph_.first_out[cell + 1];
  for (std::uint32_t next = first; next < last; ++next) {
    if (reach_[next - first] <= graph_.tolerance || next == entered) continue;
    const Window& window = windows_[next];
    if (window.run == run_ && (window.visits >= kMostVisits || window.whole)) continue;
    if (!behind(graph_.portals[next].plane)) continue;
    if (++steps_ > most_steps_) flooded_ = true;
    if (see(next)) reach(next);
  }
}

// How far the balls around the portals out of a cell reach before the plane where they do so least.
void PortalFlow::find_reaching(std::uint32_t cell) {
  const std::size_t first = graph_.first_out[cell], n = graph_.first_out[cell + 1] - first;
  reach_.assign(n, std::numeric_limits<double>::infinity());
  const double *x = &graph_.x[first], *y = &graph_.y[first], *z = &graph_.z[first];
  const double* radius = &graph_.radius[first];
  double* reach = reach_.data();
  for (const std::span<const Plane> planes : {limits_, std::span<const Plane>(planes_)})
    for (const Plane& p : planes)
      for (std::size_t i = 0; i < n; ++i) {
        const double d = p.normal.x * x[i] + p.normal.y * y[i] + p.normal.z * z[i] - p.offset;
        reach[i] = std::min(reach[i], d + radius[i]);
      }
}

// Leaves in seen_ what of the portal lies before all planes. Is there anything?
bool PortalFlow::see(std::uint32_t portal) {
  const double tolerance = graph_.tolerance;
  const Vec3 center{graph_.x[portal], graph_.y[portal], graph_.z[portal]};
  const double uncut = graph_.radius[portal] - tolerance;
  const Polygon& whole = graph_.portals[portal].polygon;
  seen_.assign(whole.begin(), whole.end());
  for (const std::span<const Plane> planes : {limits_, std::span<const Plane>(planes_)})
    for (const Plane& plane : planes) {
      if (plane.distance(center) >= uncut) continue;
      keep_seen(seen_, plane, tolerance, scratch_);
      if (seen_.size() < 3) return false;
    }
  return true;
}

// Adds seen_ to the portal's window.
void PortalFlow::reach(std::uint32_t portal) {
  Window& window = windows_[portal];
  const DirectedPortal& whole = graph_.portals[portal];
  if (window.run != run_) {
    window.run = run_;
    window.visits = 0;
    window.queued = false;
    window.whole = false;
    window.polygon.assign(seen_.begin(), seen_.end());
    reached_.push_back(portal);
  } else {
    const bool known = std::all_of(seen_.begin(), seen_.end(), [&](const Vec3& x) {
      return contains(window.polygon, whole.plane.normal, x, kPlaneNoise * graph_.tolerance);
    });
    if (known) return;
    seen_.insert(seen_.end(), window.polygon.begin(), window.polygon.end());
    window.polygon = hull_in_plane(seen_, whole.plane.normal);
  }
  if (window.visits + 1 >= kMostVisits || flooded_ || window.polygon.size() > kMostCorners ||
      area(window.polygon) > kNearlyAll * area(whole.polygon)) {
    window.polygon.assign(whole.polygon.begin(), whole.polygon.end());
    window.whole = true;
  }
  if (window.queued) return;
  window.queued = true;
  const Vec3 middle{graph_.x[portal], graph_.y[portal], graph_.z[portal]};
  queue_.push_back({length(middle - center_), portal});
  std::push_heap(queue_.begin(), queue_.end(), later);
}

}  // namespace atrium
