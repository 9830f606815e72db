#include "visibility/shaft.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "engine/check.h"
#include "visibility/convex_hull.h"
#include "visibility/remainder.h"

namespace atrium {

namespace {

// A convex polygon on the stack, with room for what clipping adds.
template <std::size_t kCapacity>
struct Corners {
  std::array<Vec3, kCapacity> at;
  std::size_t count = 0;
  void push(const Vec3& x) { at[count++] = x; }
  PolygonView view() const { return {at.data(), count}; }
};

using EndCorners = Corners<Shaft::kMaxCorners + 2>;  // one more from clipping, and room to see it

// The polygon itself, or the rectangle around it in its plane if it has too many corners.
EndCorners end_corners(PolygonView polygon, const Vec3& normal) {
  EndCorners out;
  if (polygon.size() <= Shaft::kMaxCorners) {
    for (const Vec3& x : polygon) out.push(x);
    return out;
  }
  const Vec3 u = normalize(polygon[1] - polygon[0]), v = cross(normal, u);
  Vec2 lo{0}, hi{0};
  for (const Vec3& x : polygon) {
    const Vec2 at{dot(x - polygon[0], u), dot(x - polygon[0], v)};
    lo = glm::min(lo, at);
    hi = glm::max(hi, at);
  }
  for (const Vec2& at : {lo, Vec2{hi.x, lo.y}, hi, Vec2{lo.x, hi.y}})
    out.push(polygon[0] + at.x * u + at.y * v);
  return out;
}

Plane plane_through(PolygonView polygon, const Vec3& normal) {
  Vec3 mean{0};
  for (const Vec3& x : polygon) mean += x - polygon[0];
  return {normal, dot(normal, polygon[0] + mean / double(polygon.size()))};
}

// The polygon's part in front of the plane, empty if none of it is by more than the tolerance;
// corners within the tolerance of the plane stay as they are.
EndCorners in_front(const EndCorners& polygon, const Plane& plane, double tolerance) {
  EndCorners out;
  bool any = false;
  for (std::size_t i = 0; i < polygon.count; ++i) {
    if (out.count + 2 > out.at.size()) return polygon;  // dented: the whole is conservative too
    const Vec3 &a = polygon.at[i], &b = polygon.at[i + 1 < polygon.count ? i + 1 : 0];
    const double da = plane.distance(a), db = plane.distance(b);
    any |= da > tolerance;
    if (da >= -tolerance) out.push(a);
    if ((da > tolerance && db < -tolerance) || (da < -tolerance && db > tolerance))
      out.push(a + (b - a) * (da / (da - db)));
  }
  if (!any || out.count < 3) out.count = 0;
  return out;
}

// Adds the plane with this inward normal, as far in as the hull's corners allow.
void add_plane(Shaft& shaft, const Vec3& normal, PolygonView p, PolygonView q) {
  double offset = std::numeric_limits<double>::infinity();
  for (const Vec3& x : p) offset = std::min(offset, dot(normal, x));
  for (const Vec3& x : q) offset = std::min(offset, dot(normal, x));
  shaft.planes[shaft.plane_count++] = {normal, offset};
}

// Adds the supporting planes through each edge of `from` and the extreme corner of `to`. Seen
// along an edge, the corners of `to` lie within half a turn, all being in front of `from`.
void add_supporting_planes(Shaft& shaft, PolygonView from, PolygonView to) {
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vec3& a = from[i];
    const Vec3 edge = from[i + 1 < from.size() ? i + 1 : 0] - a;
    const double edge_length = length(edge);
    if (!(edge_length > shaft.tolerance)) continue;
    Vec3 best{0};
    double reach = 0;
    for (const Vec3& c : to) {
      const Vec3 inward = cross(c - a, edge);
      const double size = length(inward);
      if (!(size > shaft.tolerance * edge_length)) continue;  // c lies on the edge's line
      if (reach == 0 || dot(best, c - a) < 0) {
        best = inward;
        reach = size;
      }
    }
    if (reach > 0) add_plane(shaft, best / reach, from, to);
  }
}

}  // namespace

Shaft make_shaft(PolygonView p, const Vec3& np, PolygonView q, const Vec3& nq, double tolerance) {
  Shaft shaft;
  shaft.tolerance = tolerance;
  const EndCorners all_p = end_corners(p, np), all_q = end_corners(q, nq);
  const EndCorners end_p = in_front(all_p, plane_through(q, nq), tolerance);
  const EndCorners end_q = in_front(all_q, plane_through(p, np), tolerance);
  if (end_p.count == 0 || end_q.count == 0) return shaft;
  shaft.closed = false;
  shaft.box = bounds(end_p.view());
  shaft.box.extend(bounds(end_q.view()));
  add_plane(shaft, np, end_p.view(), end_q.view());
  add_plane(shaft, nq, end_p.view(), end_q.view());
  add_supporting_planes(shaft, end_p.view(), end_q.view());
  add_supporting_planes(shaft, end_q.view(), end_p.view());
  return shaft;
}

Shaft make_shaft(const Box& p, const Box& q, double tolerance) {
  Shaft shaft;
  shaft.tolerance = tolerance;
  if (p.empty() || q.empty()) return shaft;
  shaft.closed = false;
  shaft.box = p;
  shaft.box.extend(q);
  // Seen along an axis the boxes are rectangles: where one reaches further in u and the other in
  // v, the line through their corners bounds the hull.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const int su : {-1, 1}) {
      for (const int sv : {-1, 1}) {
        const auto corner = [&](const Box& b) {
          return Vec2{su > 0 ? b.hi[u] : b.lo[u], sv > 0 ? b.hi[v] : b.lo[v]};
        };
        const Vec2 d = corner(q) - corner(p);
        if (!(d.x * su * d.y * sv < 0)) continue;
        Vec3 inward{0};
        inward[u] = -su * std::abs(d.y);
        inward[v] = -sv * std::abs(d.x);
        inward = normalize(inward);
        const auto support = [&](const Box& b) {
          const Vec2 c = corner(b);
          return inward[u] * c.x + inward[v] * c.y;
        };
        shaft.planes[shaft.plane_count++] = {inward, std::min(support(p), support(q))};
      }
    }
  }
  return shaft;
}

bool may_block(const Shaft& shaft, const Box& box, std::uint32_t& planes) {
  if (shaft.closed || !shaft.box.overlaps(box, -shaft.tolerance)) return false;
  const Vec3 center = box.center(), half = 0.5 * box.extent();
  std::uint32_t cutting = 0;
  for (std::uint32_t left = planes; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const Plane& plane = shaft.planes[i];
    const double distance = plane.distance(center) - shaft.tolerance;
    const double reach = std::abs(plane.normal.x) * half.x + std::abs(plane.normal.y) * half.y +
                         std::abs(plane.normal.z) * half.z;
    if (distance + reach <= 0) return false;
    if (distance - reach <= 0) cutting |= std::uint32_t{1} << i;
  }
  planes = cutting;
  return true;
}

bool may_block(const Shaft& shaft, PolygonView blocker) {
  std::uint32_t planes = shaft.all_planes();
  return may_block(shaft, bounds(blocker), planes) && may_block(shaft, blocker, planes);
}

bool may_block(const Shaft& shaft, PolygonView blocker, std::uint32_t planes) {
  // Outside one plane: the usual case, without clipping.
  std::uint32_t cutting = 0;
  for (std::uint32_t left = planes; left != 0; left &= left - 1) {
    const int i = std::countr_zero(left);
    const Plane& plane = shaft.planes[i];
    bool any_in = false, any_out = false;
    for (const Vec3& x : blocker) (plane.distance(x) > shaft.tolerance ? any_in : any_out) = true;
    if (!any_in) return false;
    if (any_out) cutting |= std::uint32_t{1} << i;
  }
  // Each cut adds a corner at most. A polygon too rich for the room here stays a candidate.
  constexpr std::size_t kRoom = 64;
  if (blocker.size() + Shaft::kMaxPlanes > kRoom) return true;
  Corners<kRoom> now, next;
  for (const Vec3& x : blocker) now.push(x);
  std::array<double, kRoom> distance;
  for (; cutting != 0; cutting &= cutting - 1) {
    const Plane& plane = shaft.planes[std::countr_zero(cutting)];
    bool any_in = false, any_out = false;
    for (std::size_t i = 0; i < now.count; ++i) {
      distance[i] = plane.distance(now.at[i]) - shaft.tolerance;
      (distance[i] > 0 ? any_in : any_out) = true;
    }
    if (!any_in) return false;
    if (!any_out) continue;
    next.count = 0;
    for (std::size_t i = 0; i < now.count; ++i) {
      const std::size_t j = i + 1 < now.count ? i + 1 : 0;
      const double a = distance[i], b = distance[j];
      if (next.count + 2 > kRoom) return true;  // dented by rounding: more crossings than corners
      if (a >= 0) next.push(now.at[i]);
      if ((a > 0 && b < 0) || (a < 0 && b > 0))
        next.push(now.at[i] + (now.at[j] - now.at[i]) * (a / (a - b)));
    }
    std::swap(now, next);
  }
  return true;
}

namespace {

// Which side of the plane the polygon is on: 1, -1, or 0 if on both or on neither.
int side_of(PolygonView polygon, const Plane& plane, double tolerance) {
  bool front = false, back = false;
  for (const Vec3& x : polygon) {
    front |= plane.distance(x) > tolerance;
    back |= plane.distance(x) < -tolerance;
  }
  return int(front) - int(back);
}

}  // namespace

bool separates(const Plane& plane, PolygonView p, PolygonView q, double tolerance) {
  const int side = side_of(p, plane, tolerance);
  return side != 0 && side_of(q, plane, tolerance) == -side;
}

bool blocks_all(PolygonView p, PolygonView q, PolygonView blocker, double tolerance) {
  const Plane plane = plane_of(blocker);
  if (!separates(plane, p, q, tolerance)) return false;
  // The corners of the hull's section lie on segments between corners of p and of q.
  for (const Vec3& a : p) {
    for (const Vec3& b : q) {
      const double da = std::abs(plane.distance(a)), db = std::abs(plane.distance(b));
      const auto inside = [&](const Vec3& x) {
        return contains(blocker, plane.normal, x, tolerance);
      };
      // A segment along the plane is in the section from end to end.
      const bool along = !(da + db > tolerance);
      if (along ? !inside(a) || !inside(b) : !inside(a + (b - a) * (da / (da + db)))) return false;
    }
  }
  return true;
}

namespace {

// Where segments between corners of p and q cross a plane between them.
Polygon crossings(PolygonView p, PolygonView q, const Plane& plane, double tolerance) {
  Polygon out;
  for (const Vec3& a : p)
    for (const Vec3& b : q) {
      const double da = std::abs(plane.distance(a)), db = std::abs(plane.distance(b));
      if (da + db > tolerance) {
        out.push_back(a + (b - a) * (da / (da + db)));
        continue;
      }
      out.push_back(a);  // a segment along the plane
      out.push_back(b);
    }
  return out;
}

// Their convex hull, the section of that of p and q.
Polygon hull_of(std::span<const Vec3> points, const Frame& frame) {
  std::vector<Vec2> flat;
  for (const Vec3& x : points) flat.push_back(frame.to_plane(x));
  Polygon out;
  for (const Vec2& x : convex_hull(std::move(flat))) out.push_back(frame.to_space(x));
  return out;
}

// The planes through a polygon's edges, upright on it, facing inward.
std::vector<Plane> upright_sides(PolygonView polygon, const Vec3& normal) {
  std::vector<Plane> sides;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 edge = polygon[i + 1 < polygon.size() ? i + 1 : 0] - polygon[i];
    if (!(length(edge) > 0)) continue;
    const Vec3 inward = normalize(cross(normal, edge));
    sides.push_back({inward, dot(inward, polygon[i])});
  }
  return sides;
}

}  // namespace

bool block_all_together(PolygonView p, PolygonView q, std::span<const PolygonView> blockers,
                        double tolerance) {
  const Frame frame = frame_of(blockers[0]);
  const Plane plane{frame.n, dot(frame.n, frame.origin)};
  if (!separates(plane, p, q, tolerance)) return false;
  // The quick no: a corner of the section that none of them covers.
  const Polygon corners = crossings(p, q, plane, tolerance);
  for (const Vec3& x : corners)
    if (std::none_of(blockers.begin(), blockers.end(), [&](PolygonView blocker) {
          return contains(blocker, plane_of(blocker).normal, x, tolerance);
        }))
      return false;
  const Polygon open = hull_of(corners, frame);
  if (open.size() < 3) return false;
  Remainder left(open);
  for (const PolygonView blocker : blockers)
    if (!left.overflow && left.count > 0)
      left.cut_out(upright_sides(blocker, plane_of(blocker).normal), tolerance);
  return left.nothing();
}

}  // namespace atrium
