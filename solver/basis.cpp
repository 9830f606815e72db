#include "solver/basis.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace atrium {

namespace {

double cross2(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

std::array<double, kMaxCoefficients> monomials(const Element& element, const Vec2& p) {
  const Vec2 t = (p - element.centroid) / element.radius;
  return {1, t.x, t.y};
}

Rule triangle_rule(std::span<const Vec2> v) {
  // Strang–Fix, degree 2, nodes inside.
  constexpr double kFar = 2.0 / 3, kNear = 1.0 / 6;
  Rule r;
  r.count = 3;
  for (int i = 0; i < 3; ++i)
    r.nodes[i] = {kFar * v[i] + kNear * v[(i + 1) % 3] + kNear * v[(i + 2) % 3], 1.0 / 3};
  return r;
}

// 2×2 Gauss through the bilinear map, its Jacobian in the weights: exact for degree 2, since
// degree 2 times the Jacobian is of degree 3 in either parameter.
Rule quadrilateral_rule(std::span<const Vec2> v, double area) {
  constexpr double kGauss = 0.211324865405187117745;  // (1 - 1/√3) / 2
  Rule r;
  r.count = 4;
  const double at[2] = {kGauss, 1 - kGauss};
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double s = at[i], t = at[j];
      const Vec2 p = (1 - t) * ((1 - s) * v[0] + s * v[1]) + t * ((1 - s) * v[3] + s * v[2]);
      const Vec2 ds = (1 - t) * (v[1] - v[0]) + t * (v[2] - v[3]);
      const Vec2 dt = (1 - s) * (v[3] - v[0]) + s * (v[2] - v[1]);
      r.nodes[2 * j + i] = {p, 0.25 * cross2(ds, dt) / area};
    }
  return r;
}

// Four nodes at ±√2 standard deviations along the principal axes: exact for degree 2 on any shape.
Rule inertia_rule(const Moments& m) {
  const double mean = 0.5 * (m.xx + m.yy), half = 0.5 * (m.xx - m.yy);
  const double root = std::hypot(half, m.xy);
  const double big = mean + root, small = std::max(0.0, mean - root);
  const double angle = 0.5 * std::atan2(m.xy, half);
  const Vec2 e{std::cos(angle), std::sin(angle)}, f{-e.y, e.x};
  const Vec2 a = std::sqrt(2 * big) * e, b = std::sqrt(2 * small) * f;
  Rule r;
  r.count = 4;
  r.nodes = {Node{m.centroid + a, 0.25}, Node{m.centroid + b, 0.25}, Node{m.centroid - a, 0.25},
             Node{m.centroid - b, 0.25}};
  return r;
}

}  // namespace

Moments moments(std::span<const Vec2> polygon) {
  Moments m;
  const Vec2 o = polygon[0];
  Vec2 first{0};
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i - 1] - o, b = polygon[i] - o;
    const double w = 0.5 * cross2(a, b);
    m.area += w;
    first += w / 3 * (a + b);
    xx += w / 6 * (a.x * a.x + a.x * b.x + b.x * b.x);
    yy += w / 6 * (a.y * a.y + a.y * b.y + b.y * b.y);
    xy += w / 12 * (2 * a.x * a.y + a.x * b.y + b.x * a.y + 2 * b.x * b.y);
  }
  if (!(m.area > 0)) {
    m.centroid = o;
    return m;
  }
  const Vec2 c = first / m.area;
  m.centroid = o + c;
  m.xx = xx / m.area - c.x * c.x;
  m.xy = xy / m.area - c.x * c.y;
  m.yy = yy / m.area - c.y * c.y;
  return m;
}

void make_basis(std::span<const Vec2> polygon, const Element& element, int order,
                std::span<double> triangle) {
  triangle[0] = 1;
  if (order < 2) return;
  // Gram matrix of (1, x, y): diagonal in the first row, since x and y are centred.
  const Moments m = moments(polygon);
  const double s = 1 / (element.radius * element.radius);
  const double xx = m.xx * s, xy = m.xy * s, yy = m.yy * s;
  // Cholesky of the 2×2 rest, inverted by hand. A needle has no width to speak of: its second
  // function is then zero and the basis is that of a line.
  constexpr double kNeedle = 1e-14;  // relative to the variance along the needle
  const double c00 = std::sqrt(std::max(xx, 0.0));
  const double c10 = c00 > 0 ? xy / c00 : 0;
  const double rest = yy - c10 * c10;
  const double c11 = rest > kNeedle * (xx + yy) ? std::sqrt(rest) : 0;
  const double l11 = c00 * c00 > kNeedle * (xx + yy) ? 1 / c00 : 0;
  const double l22 = c11 > 0 ? 1 / c11 : 0;
  triangle[1] = 0;
  triangle[2] = l11;
  triangle[3] = 0;
  triangle[4] = -c10 * l11 * l22;
  triangle[5] = l22;
}

BasisValues evaluate_basis(std::span<const double> triangle, const Element& element, int order,
                           const Vec2& p) {
  const std::array<double, kMaxCoefficients> m = monomials(element, p);
  BasisValues phi{};
  const int k = coefficient_count(order);
  for (int i = 0, t = 0; i < k; ++i)
    for (int j = 0; j <= i; ++j, ++t) phi[i] += triangle[t] * m[j];
  return phi;
}

Rule quadrature(std::span<const Vec2> polygon, const Element& element) {
  if (polygon.size() == 3) return triangle_rule(polygon);
  if (polygon.size() == 4) return quadrilateral_rule(polygon, element.area);
  return inertia_rule(moments(polygon));
}

}  // namespace atrium
