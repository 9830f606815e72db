#include "visibility/portal_flow.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atrium {

namespace {

// Noise that a separating plane may show at the polygons it separates, in tolerances.
constexpr double kPlaneNoise = 1e-3;
// Planes and windows are degenerate below this sine.
constexpr double kThinSine = 1e-9;
// A window this close to its portal's area, or with this many corners, becomes the portal.
constexpr double kNearlyAll = 0.9;
constexpr std::size_t kMostCorners = 12;

struct Range {
  double least = std::numeric_limits<double>::infinity(), most = -least;
};

Range range(std::span<const Vec3> vertices, const Vec3& normal) {
  Range r;
  for (const Vec3& x : vertices) {
    const double d = dot(normal, x);
    r.least = std::min(r.least, d), r.most = std::max(r.most, d);
  }
  return r;
}

double cross2(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

// Adds the plane with the source behind it and the window before it, if it is one.
void add_if_between(Vec3 normal, std::span<const Vec3> source, PolygonView window, double noise,
                    std::vector<Plane>& out) {
  const Range s = range(source, normal), w = range(window, normal);
  if (s.most <= w.least + noise)
    out.push_back({normal, w.least});
  else if (w.most <= s.least + noise)
    out.push_back({-normal, -w.most});
}

// The planes through an edge of one of the two, touching the other, that have the source behind
// and the window before them. Seen along the edge both are point sets in a plane about the edge,
// the origin; the touching planes are the lines to the outermost points of the other.
void planes_through(const Vec3& a, const Vec3& b, std::span<const Vec3> other,
                    std::span<const Vec3> source, PolygonView window, double noise,
                    std::vector<Plane>& out) {
  const double l = length(b - a);
  if (!(l > noise)) return;
  const Vec3 d = (b - a) / l;
  const Vec3 steep = std::abs(d.x) > 0.5 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  const Vec3 e1 = normalize(cross(d, steep)), e2 = cross(d, e1);
  Vec2 first{0}, last{0};
  bool any = false;
  for (const Vec3& x : other) {
    const Vec2 q{dot(x - a, e1), dot(x - a, e2)};
    if (std::abs(q.x) + std::abs(q.y) <= noise) continue;  // on the edge's line: touches any plane
    if (!any || cross2(first, q) < 0) first = q;
    if (!any || cross2(last, q) > 0) last = q;
    any = true;
  }
  if (!any) return;
  const auto normal = [&](const Vec2& t) { return normalize(t.x * e2 - t.y * e1); };
  add_if_between(normal(last), source, window, noise, out);
  if (std::abs(cross2(first, last)) > kThinSine * glm::length(first) * glm::length(last))
    add_if_between(normal(first), source, window, noise, out);
}

void separating_planes(const ConvexSource& source, PolygonView window, double noise,
                       std::vector<Plane>& out) {
  for (const auto& [i, j] : source.edges)
    planes_through(source.vertices[i], source.vertices[j], window, source.vertices, window, noise,
                   out);
  for (std::size_t i = 0; i < window.size(); ++i)
    planes_through(window[i], window[(i + 1) % window.size()], source.vertices, source.vertices,
                   window, noise, out);
}

// Fewer planes bound less: to drop one is always safe.
void drop_repeats(std::vector<Plane>& planes, double noise) {
  std::size_t kept = 0;
  for (const Plane& p : planes) {
    const bool repeated = std::any_of(
        planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(kept), [&](const Plane& q) {
          return length(p.normal - q.normal) < kThinSine && std::abs(p.offset - q.offset) < noise;
        });
    if (!repeated) planes[kept++] = p;
  }
  planes.resize(kept);
}

// What of the polygon lies before the plane, a tolerance to spare; nothing if all of it that does
// is within tolerance of the plane.
Polygon seen_before(Polygon polygon, const Plane& plane, double tolerance) {
  bool cut = false, any = false;
  for (const Vec3& x : polygon) {
    const double d = plane.distance(x);
    cut |= d < -tolerance;
    any |= d > tolerance;
  }
  if (!any) return {};
  if (!cut) return polygon;
  return clip(polygon, {plane.normal, plane.offset - tolerance}, 0);
}

// The convex hull of points in one plane, counter-clockwise about its normal.
Polygon hull_in_plane(std::vector<Vec3> points, const Vec3& normal) {
  const Vec3 steep = std::abs(normal.x) > 0.5 ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  const Vec3 u = normalize(cross(steep, normal)), v = cross(normal, u);
  struct Flat {
    Vec2 p;
    std::size_t index;
  };
  std::vector<Flat> flat;
  for (std::size_t i = 0; i < points.size(); ++i)
    flat.push_back({{dot(points[i], u), dot(points[i], v)}, i});
  std::sort(flat.begin(), flat.end(), [](const Flat& a, const Flat& b) {
    return a.p.x != b.p.x ? a.p.x < b.p.x : a.p.y < b.p.y;
  });
  std::vector<Flat> out;
  auto add = [&out](const Flat& f, std::size_t floor) {
    while (out.size() >= floor + 2) {
      const Vec2 a = out.back().p - out[out.size() - 2].p, b = f.p - out.back().p;
      if (a.x * b.y - a.y * b.x > 0) break;
      out.pop_back();
    }
    out.push_back(f);
  };
  for (const Flat& f : flat) add(f, 0);
  const std::size_t lower = out.size() - 1;
  for (std::size_t i = flat.size() - 1; i-- > 0;) add(flat[i], lower);
  out.pop_back();
  Polygon polygon;
  for (const Flat& f : out) polygon.push_back(points[f.index]);
  return polygon;
}

}  // namespace

ConvexSource source_of(PolygonView polygon) {
  ConvexSource source{{polygon.begin(), polygon.end()}, {}};
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (std::uint32_t i = 0; i < n; ++i) source.edges.emplace_back(i, (i + 1) % n);
  return source;
}

ConvexSource source_of(const Frame& frame, const Box& box, double tolerance) {
  ConvexSource source;
  std::uint32_t id[8];
  for (unsigned corner = 0; corner < 8; ++corner) {
    // A flat box has one corner where a full one has two.
    unsigned same = corner;
    Vec3 x;
    for (int k = 0; k < 3; ++k) {
      const bool flat = box.hi[k] - box.lo[k] <= tolerance;
      if (flat) same &= ~(1u << k);
      x[k] = corner >> k & 1u ? box.hi[k] : box.lo[k];
    }
    if (same != corner) {
      id[corner] = id[same];
      continue;
    }
    id[corner] = static_cast<std::uint32_t>(source.vertices.size());
    source.vertices.push_back(frame.origin + x.x * frame.u + x.y * frame.v + x.z * frame.n);
  }
  for (unsigned corner = 0; corner < 8; ++corner)
    for (unsigned k = 0; k < 3; ++k) {
      const unsigned other = corner | 1u << k;
      if (other != corner && id[other] != id[corner] &&
          (source.vertices.size() == 8 ||
           std::none_of(source.edges.begin(), source.edges.end(), [&](const auto& e) {
             return e.first == id[corner] && e.second == id[other];
           })))
        source.edges.emplace_back(id[corner], id[other]);
    }
  return source;
}

PortalGraph make_graph(const Bsp& bsp, const std::vector<CellPortal>& portals) {
  PortalGraph graph;
  graph.tolerance = bsp.tolerance;
  graph.out_of.resize(bsp.cells.size());
  for (const CellPortal& p : portals) {
    const Plane plane = bsp.nodes[p.node].plane;
    graph.out_of[p.front].push_back(static_cast<std::uint32_t>(graph.portals.size()));
    graph.portals.push_back(
        {{p.polygon.rbegin(), p.polygon.rend()}, plane.flipped(), p.front, p.back});
    graph.out_of[p.back].push_back(static_cast<std::uint32_t>(graph.portals.size()));
    graph.portals.push_back({p.polygon, plane, p.back, p.front});
  }
  return graph;
}

PortalFlow::PortalFlow(const PortalGraph& graph) : graph_(graph), windows_(graph.portals.size()) {}

void PortalFlow::start(const ConvexSource& source, std::size_t most_steps) {
  source_ = source;
  center_ = Vec3{0};
  for (const Vec3& x : source_.vertices) center_ += x / double(source_.vertices.size());
  ++run_;
  steps_ = 0;
  most_steps_ = most_steps;
  flooded_ = false;
  reached_.clear();
  queue_.clear();
  planes_.clear();
}

void PortalFlow::run_from_cell(const ConvexSource& source, std::uint32_t cell,
                               std::size_t most_steps) {
  source_portal_ = kNone;
  start(source, most_steps);
  spread(cell, kNone);
  drain();
}

void PortalFlow::run_through(std::uint32_t portal, std::size_t most_steps) {
  source_portal_ = portal;
  start(source_of(graph_.portals[portal].polygon), most_steps);
  planes_.push_back(graph_.portals[portal].plane);
  spread(graph_.portals[portal].to, portal);
  drain();
}

void PortalFlow::drain() {
  while (!queue_.empty()) {
    std::pop_heap(queue_.begin(), queue_.end(), [](const Waiting& a, const Waiting& b) {
      return a.distance != b.distance ? a.distance > b.distance : a.portal > b.portal;
    });
    const std::uint32_t portal = queue_.back().portal;
    queue_.pop_back();
    windows_[portal].queued = false;
    ++windows_[portal].visits;
    bounding_planes(portal);
    spread(graph_.portals[portal].to, portal);
    windows_[portal].planes = planes_;
  }
}

// The planes that bound what is seen through a reached portal's window.
void PortalFlow::bounding_planes(std::uint32_t portal) {
  planes_.clear();
  if (!flooded_) {
    const double noise = kPlaneNoise * graph_.tolerance;
    separating_planes(source_, windows_[portal].polygon, noise, planes_);
    drop_repeats(planes_, noise);
  }
  planes_.push_back(graph_.portals[portal].plane);
  if (source_portal_ != kNone) planes_.push_back(graph_.portals[source_portal_].plane);
}

bool PortalFlow::behind(const Plane& plane) const {
  return std::any_of(source_.vertices.begin(), source_.vertices.end(),
                     [&](const Vec3& x) { return plane.distance(x) < -graph_.tolerance; });
}

void PortalFlow::spread(std::uint32_t cell, std::uint32_t entered) {
  for (std::uint32_t next : graph_.out_of[cell]) {
    if (entered != kNone && next == (entered ^ 1u)) continue;
    const DirectedPortal& portal = graph_.portals[next];
    if (source_portal_ != kNone && next >> 1 == source_portal_ >> 1) continue;
    const Window& window = windows_[next];
    if (window.run == run_ && window.visits >= kMostVisits) continue;
    if (!behind(portal.plane)) continue;
    if (++steps_ > most_steps_) flooded_ = true;
    Polygon seen = portal.polygon;
    for (const Plane& plane : planes_) {
      seen = seen_before(std::move(seen), plane, graph_.tolerance);
      if (seen.size() < 3) break;
    }
    if (seen.size() >= 3) reach(next, std::move(seen));
  }
}

void PortalFlow::reach(std::uint32_t portal, Polygon seen) {
  Window& window = windows_[portal];
  const DirectedPortal& whole = graph_.portals[portal];
  if (window.run != run_) {
    window.run = run_;
    window.visits = 0;
    window.queued = false;
    window.polygon = std::move(seen);
    reached_.push_back(portal);
  } else {
    const bool known = std::all_of(seen.begin(), seen.end(), [&](const Vec3& x) {
      return contains(window.polygon, whole.plane.normal, x, kPlaneNoise * graph_.tolerance);
    });
    if (known) return;
    seen.insert(seen.end(), window.polygon.begin(), window.polygon.end());
    window.polygon = hull_in_plane(std::move(seen), whole.plane.normal);
  }
  if (window.visits + 1 >= kMostVisits || flooded_ || window.polygon.size() > kMostCorners ||
      area(window.polygon) > kNearlyAll * area(whole.polygon))
    window.polygon = whole.polygon;
  if (window.queued) return;
  window.queued = true;
  queue_.push_back({length(centroid(whole.polygon) - center_), portal});
  std::push_heap(queue_.begin(), queue_.end(), [](const Waiting& a, const Waiting& b) {
    return a.distance != b.distance ? a.distance > b.distance : a.portal > b.portal;
  });
}

}  // namespace atrium
