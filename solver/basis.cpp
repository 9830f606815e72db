#include "solver/basis.h"

#include <algorithm>
#include <cmath>

#include "solver/gauss.h"
#include "solver/outline.h"

namespace atrium {

namespace {

double cross2(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

constexpr int kLinear = coefficient_count(2);  // functions of degree 0 and 1

// φ0, φ1, φ2 at p, as far as the order has them.
BasisValues linear_part(std::span<const double> triangle, const Element& element, int order,
                        const Vec2& p) {
  BasisValues phi{};
  phi[0] = triangle[0];
  if (order < 2) return phi;
  const Vec2 x = (p - element.centroid) / element.radius;
  phi[1] = triangle[1] + triangle[2] * x.x;
  phi[2] = triangle[3] + triangle[4] * x.x + triangle[5] * x.y;
  return phi;
}

// What the quadratic functions are made of.
BasisValues products(const BasisValues& phi) {
  return {1, phi[1], phi[2], phi[1] * phi[1], phi[1] * phi[2], phi[2] * phi[2]};
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

// The point of a quadrilateral at (s, t) of the unit square, weighed by the bilinear map's
// Jacobian.
Node bilinear_node(std::span<const Vec2> v, double area, double s, double t) {
  const Vec2 p = (1 - t) * ((1 - s) * v[0] + s * v[1]) + t * ((1 - s) * v[3] + s * v[2]);
  const Vec2 ds = (1 - t) * (v[1] - v[0]) + t * (v[2] - v[3]);
  const Vec2 dt = (1 - s) * (v[3] - v[0]) + s * (v[2] - v[1]);
  return {p, cross2(ds, dt) / area};
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
      Node node = bilinear_node(v, area, at[i], at[j]);
      node.weight *= 0.25;
      r.nodes[2 * j + i] = node;
    }
  return r;
}

// From centre against mean of a parabola's four Gauss nodes to the root mean square of its misfit
// to a plane: √(4/45) / (1/3).
constexpr double kBowlOfPlane = 0.894;

// Shares of cubics that the nodes of order 3 see, on the average over an orthonormal set of four:
// the sum of what a least squares fit at the nodes leaves over of each. Affine maps change nothing
// for the first two; the others are what measured quadrilaterals and polygons have about them.
constexpr double kSeenInParallelogram = 1, kSeenInTriangle = 0.296;
constexpr double kSeenInQuadrilateral = 0.42, kSeenInPolygon = 0.3;
// The nodes of the parallelogram are blind to all quartics, but the centre misses a fit to one of
// norm 1 by √2.44 on the same average.
constexpr double kBowlOfParallelogram = 0.64;

// [Radon 1948; Strang & Fix 1973, degree 5]
Rule triangle_rule_of_degree_5(std::span<const Vec2> v) {
  constexpr double kCenter = 0.225;
  constexpr double kOffCorner = 0.101286507323456338801, kByCorner = 0.125939180544827152596;
  constexpr double kOffEdge = 0.470142064105115089771, kByEdge = 0.132394152788506180738;
  Rule r;
  r.count = 7;
  r.cubic_seen = kSeenInTriangle;
  r.nodes[0] = {(v[0] + v[1] + v[2]) / 3.0, kCenter};
  for (int i = 0; i < 3; ++i) {
    const Vec2& a = v[i];
    const Vec2 others = v[(i + 1) % 3] + v[(i + 2) % 3];
    r.nodes[1 + i] = {(1 - 2 * kOffCorner) * a + kOffCorner * others, kByCorner};
    r.nodes[4 + i] = {(1 - 2 * kOffEdge) * a + kOffEdge * others, kByEdge};
  }
  return r;
}

// [Burnside 1908, degree 5], on [-1, 1]²: four nodes on the axes, four on the diagonals.
Rule parallelogram_rule(std::span<const Vec2> v) {
  constexpr double kOnAxis = 0.683130051063973225548, kAxisWeight = 10.0 / 49;        // √(7/15)
  constexpr double kDiagonal = 0.881917103688196863500, kDiagonalWeight = 9.0 / 196;  // √(7/9)
  const Vec2 center = 0.5 * (v[0] + v[2]), s = 0.5 * (v[1] - v[0]), t = 0.5 * (v[3] - v[0]);
  const Vec2 a = kOnAxis * s, b = kOnAxis * t, c = kDiagonal * (s + t), d = kDiagonal * (s - t);
  Rule r;
  r.count = 8;
  r.cubic_seen = kSeenInParallelogram;
  r.bowl = kBowlOfParallelogram;
  r.nodes = {Node{center + a, kAxisWeight},     Node{center + b, kAxisWeight},
             Node{center - a, kAxisWeight},     Node{center - b, kAxisWeight},
             Node{center + c, kDiagonalWeight}, Node{center + d, kDiagonalWeight},
             Node{center - c, kDiagonalWeight}, Node{center - d, kDiagonalWeight}};
  return r;
}

bool is_parallelogram(std::span<const Vec2> v, double radius) {
  constexpr double kTolerance = 1e-9;  // of the radius
  const Vec2 off = v[0] - v[1] + v[2] - v[3];
  return v.size() == 4 && std::hypot(off.x, off.y) <= kTolerance * radius;
}

// 3×3 Gauss through the bilinear map: exact for degree 4, since degree 4 times the Jacobian is of
// degree 5 in either parameter.
Rule quadrilateral_rule_of_degree_4(std::span<const Vec2> v, double area) {
  using Nodes = Gauss<3>;
  Rule r;
  r.cubic_seen = kSeenInQuadrilateral;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i) {
      Node node = bilinear_node(v, area, Nodes::node[i], Nodes::node[j]);
      node.weight *= Nodes::weight[i] * Nodes::weight[j];
      r.nodes[r.count++] = node;
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

// The nodes of both halves: enough to tell all quadratics apart, which four or six on an ellipse
// are not.
Rule rule_of_halves(std::span<const Vec2> polygon, const Element& element) {
  Rule r;
  r.exact_products = false;
  r.cubic_seen = kSeenInPolygon;
  for (const Outline& half : halve(polygon, element.centroid)) {
    const Moments m = moments(half);
    const Rule part = inertia_rule(m);
    for (const Node& node : std::span(part.nodes).first(part.count))
      r.nodes[r.count++] = {node.p, node.weight * m.area / element.area};
  }
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

namespace {

// The rows of φ3, φ4 and φ5 by Gram and Schmidt on φ1², φ1φ2 and φ2². Where φ2 is zero, as in a
// needle without width, so are the functions made with it.
void make_quadratics(std::span<const Vec2> polygon, const Element& element,
                     std::span<double> triangle) {
  SquareMatrix gram{};
  for_each_product_node(polygon, element, kMaxOrder, [&](const Node& node) {
    const BasisValues m = products(linear_part(triangle, element, kMaxOrder, node.p));
    for (int i = 0; i < kMaxCoefficients; ++i)
      for (int j = 0; j < kMaxCoefficients; ++j) gram[i][j] += node.weight * m[i] * m[j];
  });
  // Each function's coefficients over the products.
  SquareMatrix phi{};
  for (int i = 0; i < kLinear; ++i) phi[i][i] = i == 0 || gram[i][i] > 0;
  for (int i = kLinear, t = triangle_count(2); i < kMaxCoefficients; ++i) {
    constexpr double kNothing = 1e-9;  // of a convex shape's, which are of the order of 1
    const auto inner = [&](const BasisValues& a, const BasisValues& b) {
      double sum = 0;
      for (int p = 0; p < kMaxCoefficients; ++p)
        for (int q = 0; q < kMaxCoefficients; ++q) sum += a[p] * gram[p][q] * b[q];
      return sum;
    };
    BasisValues f{};
    f[i] = 1;
    for (int j = 0; j < i; ++j) {
      const double share = inner(phi[j], f);
      for (int p = 0; p <= j; ++p) f[p] -= share * phi[j][p];
    }
    const double norm2 = inner(f, f);
    const double scale = norm2 > kNothing ? 1 / std::sqrt(norm2) : 0;
    for (int j = 0; j <= i; ++j) triangle[t++] = phi[i][j] = scale * f[j];
  }
}

}  // namespace

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
  if (order > 2) make_quadratics(polygon, element, triangle);
}

BasisValues evaluate_basis(std::span<const double> triangle, const Element& element, int order,
                           const Vec2& p) {
  BasisValues phi = linear_part(triangle, element, order, p);
  if (order < 3) return phi;
  const BasisValues m = products(phi);
  for (int i = kLinear, t = triangle_count(2); i < kMaxCoefficients; ++i)
    for (int j = 0; j <= i; ++j, ++t) phi[i] += triangle[t] * m[j];
  return phi;
}

Rule quadrature(std::span<const Vec2> polygon, const Element& element, int order) {
  const std::size_t corners = polygon.size();
  if (order < 3) {
    Rule r = corners == 3   ? triangle_rule(polygon)
             : corners == 4 ? quadrilateral_rule(polygon, element.area)
                            : inertia_rule(moments(polygon));
    r.bowl = kBowlOfPlane;
    return r;
  }
  if (corners == 3) return triangle_rule_of_degree_5(polygon);
  if (is_parallelogram(polygon, element.radius)) return parallelogram_rule(polygon);
  if (corners == 4) return quadrilateral_rule_of_degree_4(polygon, element.area);
  return rule_of_halves(polygon, element);
}

}  // namespace atrium
