#include "engine/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace atrium {

void Box::extend(const Vec3& x) {
  for (int k = 0; k < 3; ++k) {
    lo[k] = std::min(lo[k], x[k]);
    hi[k] = std::max(hi[k], x[k]);
  }
}

void Box::extend(const Box& b) {
  if (b.empty()) return;
  extend(b.lo);
  extend(b.hi);
}

bool Box::overlaps(const Box& b, double margin) const {
  for (int k = 0; k < 3; ++k)
    if (lo[k] > b.hi[k] + margin || b.lo[k] > hi[k] + margin) return false;
  return true;
}

bool Box::contains(const Vec3& x, double margin) const {
  for (int k = 0; k < 3; ++k)
    if (x[k] < lo[k] - margin || x[k] > hi[k] + margin) return false;
  return true;
}

Box bounds(PolygonView points) {
  Box box;
  for (const Vec3& x : points) box.extend(x);
  return box;
}

Vec3 area_vector(PolygonView polygon) {
  // Relative to a vertex: far from the origin the products would cancel.
  Vec3 sum{0};
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum += cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]);
  return sum;
}

double area(PolygonView polygon) { return 0.5 * length(area_vector(polygon)); }

Vec3 centroid(PolygonView polygon) {
  Vec3 n = area_vector(polygon);
  double total = length(n);
  if (!(total > 0)) return bounds(polygon).center();
  n /= total;
  Vec3 sum{0};
  double weight = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    Vec3 a = polygon[i - 1] - polygon[0], b = polygon[i] - polygon[0];
    double w = dot(n, cross(a, b));
    sum += w * (a + b);
    weight += w;
  }
  return polygon[0] + sum / (3 * weight);
}

Plane plane_of(PolygonView polygon) {
  Vec3 n = area_vector(polygon);
  double l = length(n);
  if (!(l > 0)) return {Vec3{0}, 0};
  n /= l;
  Vec3 mean{0};
  for (const Vec3& x : polygon) mean += x - polygon[0];
  return {n, dot(n, polygon[0] + mean / double(polygon.size()))};
}

double planarity(PolygonView polygon) {
  Plane p = plane_of(polygon);
  double worst = 0;
  for (const Vec3& x : polygon) worst = std::max(worst, std::abs(p.distance(x)));
  return worst;
}

namespace {

// Appends to `out` the part of the polygon with sign * distance >= 0.
Polygon half(PolygonView polygon, std::span<const double> d, double sign, double tolerance) {
  Polygon out;
  bool any = false;
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t j = (i + 1) % n;
    const double a = sign * d[i], b = sign * d[j];
    if (a >= -tolerance) {
      out.push_back(polygon[i]);
      any |= a > tolerance;
    }
    if ((a > tolerance && b < -tolerance) || (a < -tolerance && b > tolerance)) {
      // The same expression from either side, so that both halves get the same point.
      const std::size_t p = d[i] > d[j] ? i : j, q = p == i ? j : i;
      out.push_back(polygon[p] + (polygon[q] - polygon[p]) * (d[p] / (d[p] - d[q])));
    }
  }
  if (!any || out.size() < 3) out.clear();
  return out;
}

}  // namespace

Polygon clip(PolygonView polygon, const Plane& plane, double tolerance) {
  std::vector<double> d(polygon.size());
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = plane.distance(polygon[i]);
  return half(polygon, d, 1, tolerance);
}

Split split(PolygonView polygon, const Plane& plane, double tolerance) {
  std::vector<double> d(polygon.size());
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = plane.distance(polygon[i]);
  return {half(polygon, d, 1, tolerance), half(polygon, d, -1, tolerance)};
}

bool contains(PolygonView polygon, const Vec3& normal, const Vec3& x, double tolerance) {
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& a = polygon[i];
    const Vec3 edge = polygon[(i + 1) % n] - a;
    const double l = length(edge);
    if (l > 0 && dot(cross(edge, x - a), normal) < -tolerance * l) return false;
  }
  return true;
}

double distance_to(PolygonView polygon, const Vec3& x) {
  const Plane plane = plane_of(polygon);
  const double above = plane.distance(x);
  if (contains(polygon, plane.normal, x - above * plane.normal, 0)) return std::abs(above);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 a = polygon[i], edge = polygon[(i + 1) % polygon.size()] - a;
    const double squared = dot(edge, edge);
    const double t = squared > 0 ? std::clamp(dot(x - a, edge) / squared, 0.0, 1.0) : 0;
    least = std::min(least, length(x - a - t * edge));
  }
  return least;
}

bool is_convex(PolygonView polygon, double tolerance) {
  const Plane p = plane_of(polygon);
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3& a = polygon[i];
    const Vec3 edge = polygon[(i + 1) % n] - a;
    const double l = length(edge);
    if (!(l > 0)) continue;
    const Vec3 inward = cross(p.normal, edge) / l;
    for (const Vec3& x : polygon)
      if (dot(inward, x - a) < -tolerance) return false;
  }
  return true;
}

Frame frame_of(PolygonView polygon) {
  Frame f;
  f.origin = centroid(polygon);
  f.n = plane_of(polygon).normal;
  Vec3 longest{0};
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 e = polygon[(i + 1) % n] - polygon[i];
    // The first of equal edges wins, with room for rounding, so that a shifted copy agrees.
    if (length(e) > length(longest) * (1 + 1e-9)) longest = e;
  }
  Vec3 u = longest - dot(longest, f.n) * f.n;
  f.u = length(u) > 0 ? normalize(u) : Vec3{1, 0, 0};
  f.v = cross(f.n, f.u);
  return f;
}

Box bounds(PolygonView points, const Frame& frame) {
  Box box;
  for (const Vec3& x : points) box.extend(frame.to_frame(x));
  return box;
}

Frame frame_about(const Vec3& n) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {.u = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x},
          .v = {b, sign + n.y * n.y * a, -n.y},
          .n = n};
}

namespace {

// A point of the unit disc, by its squared distance from the centre and its angle.
Vec3 lifted(const Frame& f, double r2, double angle) {
  const double r = std::sqrt(r2);
  return r * std::cos(angle) * f.u + r * std::sin(angle) * f.v + std::sqrt(1 - r2) * f.n;
}

}  // namespace

Vec3 cosine_direction(const Frame& frame, int i, int count) {
  constexpr double kGoldenAngle = 2.39996322972865332;
  return lifted(frame, (i + 0.5) / count, kGoldenAngle * i);
}

Vec3 cosine_direction(const Frame& frame, const Vec2& square) {
  return lifted(frame, square.x, 2 * std::numbers::pi * square.y);
}

double fan_area(PolygonView polygon, std::size_t i) {
  return 0.5 * length(cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]));
}

Vec3 point_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec2& square) {
  const Vec3 far = b + square.y * (c - b);
  return a + std::sqrt(square.x) * (far - a);
}

// The first coordinate chooses a triangle of the fan, and what is left of it a place there.
Vec3 point_of(PolygonView polygon, const Vec2& square) {
  double whole = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) whole += fan_area(polygon, i);
  double left = square.x * whole, part = fan_area(polygon, 2);
  std::size_t i = 2;
  for (; i + 1 < polygon.size() && left >= part; part = fan_area(polygon, ++i)) left -= part;
  const double share = part > 0 ? std::min(1.0, left / part) : 0;
  return point_of(polygon[0], polygon[i - 1], polygon[i], {share, square.y});
}

}  // namespace atrium
