// The basis of an element and the rules it is integrated with, against a quadrature that owes them
// nothing.
#include "solver/basis.h"

#include <gtest/gtest.h>

#include "test/solver/shapes.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

constexpr double kScales[] = {1e-6, 1, 1e6};

struct Case {
  Shape shape;
  double scale;
};

std::vector<Case> cases() {
  std::vector<Case> all;
  for (const Shape& s : shapes())
    for (const double scale : kScales) {
      all.push_back({s, scale});
      all.back().shape.outline = moved(s.outline, scale, 0, {0, 0});
    }
  return all;
}

std::string name(const Case& c) { return c.shape.name + " × " + std::to_string(c.scale); }

PatchTree tree_of(const Case& c, int order) {
  Patches patches(order);
  return patches.tree(patches.add(in_plane(c.shape.outline)));
}

// The Gram matrix of (1, x, y) over a shape of aspect a has a condition number of about a²: that
// much rounding is no fault of the basis. A dozen roundings.
double rounding(const Case& c) { return 12 * 2.3e-16 * (10 + c.shape.aspect * c.shape.aspect); }

TEST(Basis, OrthonormalInTheMeanOnEveryShapeAndScale) {
  for (const int order : {1, 2})
    for (const Case& c : cases()) {
      SCOPED_TRACE(name(c) + ", order " + std::to_string(order));
      const PatchTree tree = tree_of(c, order);
      const PatchView v = tree.view();
      const Element& x = tree.elements[0];
      const std::span<const Vec2> outline = v.polygon(x);
      const double whole = area2(outline);
      for (int i = 0; i < v.k(); ++i)
        for (int j = 0; j <= i; ++j) {
          const double mean = integrate(outline, 1,
                                        [&](const Vec2& p) {
                                          const BasisValues f =
                                              evaluate_basis(v.basis_of(0), x, order, p);
                                          return f[i] * f[j];
                                        }) /
                              whole;
          EXPECT_NEAR(mean, i == j, rounding(c)) << "φ" << i << " φ" << j;
        }
    }
}

TEST(Basis, FirstFunctionIsOneEverywhere) {
  std::mt19937 dice(1);
  for (const Case& c : cases()) {
    const PatchTree tree = tree_of(c, 2);
    const PatchView v = tree.view();
    for (int n = 0; n < 5; ++n) {
      const Vec2 p = point_of(v.polygon(tree.elements[0]), dice);
      EXPECT_EQ(evaluate_basis(v.basis_of(0), tree.elements[0], 2, p)[0], 1.0) << name(c);
    }
  }
}

// A square of edge a: φ1 = √12 (x - a/2) / a.
TEST(Basis, OfASquareIsScaledLegendre) {
  Patches patches(2);
  const PatchTree tree =
      patches.tree(patches.add(in_plane(std::vector<Vec2>{{0, 0}, {3, 0}, {3, 3}, {0, 3}})));
  const PatchView v = tree.view();
  const Vec2 corner = v.polygon(tree.elements[0])[2];
  const BasisValues f = evaluate_basis(v.basis_of(0), tree.elements[0], 2, corner);
  EXPECT_NEAR(std::abs(f[1]), std::sqrt(3.0), 1e-14);
  EXPECT_NEAR(std::abs(f[2]), std::sqrt(3.0), 1e-14);
}

// Six monomials of degree ≤ 2 about the centroid, in units of the radius.
TEST(Quadrature, ExactForDegreeTwoOnEveryShapeAndScale) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(name(c));
    const PatchTree tree = tree_of(c, 2);
    const Element& x = tree.elements[0];
    const std::span<const Vec2> outline = tree.view().polygon(x);
    const double whole = area2(outline);
    const Rule rule = quadrature(outline, x);
    for (int i = 0; i <= 2; ++i)
      for (int j = 0; i + j <= 2; ++j) {
        const auto f = [&](const Vec2& p) {
          const Vec2 t = (p - x.centroid) / x.radius;
          return std::pow(t.x, i) * std::pow(t.y, j);
        };
        double sum = 0;
        for (int q = 0; q < rule.count; ++q) sum += rule.nodes[q].weight * f(rule.nodes[q].p);
        EXPECT_NEAR(sum, integrate(outline, 0, f) / whole, rounding(c)) << "x^" << i << " y^" << j;
      }
  }
}

TEST(Quadrature, NodesInsideAndWeightsPositive) {
  for (const Case& c : cases()) {
    const PatchTree tree = tree_of(c, 2);
    const Element& x = tree.elements[0];
    const std::span<const Vec2> outline = tree.view().polygon(x);
    const Rule rule = quadrature(outline, x);
    ASSERT_GE(rule.count, 3);
    for (int q = 0; q < rule.count; ++q) {
      EXPECT_TRUE(inside(outline, rule.nodes[q].p, 1e-9 * x.radius)) << name(c) << ", node " << q;
      EXPECT_GT(rule.nodes[q].weight, 0) << name(c);
    }
  }
}

TEST(Moments, OfARectangle) {
  const std::vector<Vec2> outline{{1, 1}, {4, 1}, {4, 3}, {1, 3}};
  const Moments m = moments(outline);
  EXPECT_NEAR(m.area, 6, 1e-14);
  EXPECT_NEAR(m.centroid.x, 2.5, 1e-14);
  EXPECT_NEAR(m.centroid.y, 2, 1e-14);
  EXPECT_NEAR(m.xx, 9.0 / 12, 1e-14);
  EXPECT_NEAR(m.xy, 0, 1e-14);
  EXPECT_NEAR(m.yy, 4.0 / 12, 1e-14);
}

TEST(Moments, OfARightTriangle) {
  const double b = 3, h = 2;
  const Moments m = moments(std::vector<Vec2>{{0, 0}, {b, 0}, {0, h}});
  EXPECT_NEAR(m.area, b * h / 2, 1e-14);
  EXPECT_NEAR(m.centroid.x, b / 3, 1e-14);
  EXPECT_NEAR(m.centroid.y, h / 3, 1e-14);
  EXPECT_NEAR(m.xx, b * b / 18, 1e-14);
  EXPECT_NEAR(m.yy, h * h / 18, 1e-14);
  EXPECT_NEAR(m.xy, -b * h / 36, 1e-14);
}

TEST(Moments, OfARegularHexagonAtAnyPlace) {
  const double s = 0.5;
  const Moments m = moments(moved(regular(6, s), 1, 20, {300, -70}));
  EXPECT_NEAR(m.area, 1.5 * std::sqrt(3.0) * s * s, 1e-11);
  EXPECT_NEAR(m.centroid.x, 300, 1e-11);
  EXPECT_NEAR(m.centroid.y, -70, 1e-11);
  EXPECT_NEAR(m.xx, 5 * s * s / 24, 1e-13);
  EXPECT_NEAR(m.yy, 5 * s * s / 24, 1e-13);
  EXPECT_NEAR(m.xy, 0, 1e-13);
}

TEST(Moments, EqualThoseOfQuadratureOnEveryShape) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(name(c));
    const std::vector<Vec2>& outline = c.shape.outline;
    const Moments m = moments(outline);
    const double whole = area2(outline);
    const auto mean = [&](const auto& f) { return integrate(outline, 0, f) / whole; };
    const double length2 = m.xx + m.yy;
    // The coordinates themselves are rounded where the shape stands far from the origin.
    const double far2 = std::pow(std::hypot(outline[0].x, outline[0].y), 2);
    const double tolerance = 1e-12 * length2 + 1e-15 * std::sqrt(far2 * length2);
    EXPECT_NEAR(m.area, whole, 1e-13 * length2 + 1e-13 * whole);
    EXPECT_NEAR(mean([&](const Vec2& p) { return std::pow(p.x - m.centroid.x, 2); }), m.xx,
                tolerance);
    EXPECT_NEAR(mean([&](const Vec2& p) { return std::pow(p.y - m.centroid.y, 2); }), m.yy,
                tolerance);
    EXPECT_NEAR(mean([&](const Vec2& p) { return (p.x - m.centroid.x) * (p.y - m.centroid.y); }),
                m.xy, tolerance);
  }
}

}  // namespace
}  // namespace atrium::testing
