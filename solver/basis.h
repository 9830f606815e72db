// The basis of an element: polynomials of total degree below `order` in the plane, orthonormal over
// the element in the mean: (1/A) ∫ φi φj = δij. φ0 = 1, so coefficient 0 is the element's mean.
// Multiwavelets on an arbitrary convex element: a child's space holds its parent's, so that push is
// exact and pull is the L2 projection. [GSCH93, Alpert]
//
// A basis is stored as the lower triangle L of φ = L m with m = (1, x, y, φ1², φ1φ2, φ2²), the
// coordinates in (p - centroid) / radius: over φ1 and φ2, which are orthonormal themselves, the
// quadratic functions of a needle are as well conditioned as those of a square. Pure functions, any
// thread.
#pragma once

#include <array>
#include <span>

#include "engine/element.h"

namespace atrium {

using BasisValues = std::array<double, kMaxCoefficients>;
using SquareMatrix = std::array<BasisValues, kMaxCoefficients>;

// Writes the triangle of an element with this polygon (convex, counter-clockwise).
void make_basis(std::span<const Vec2> polygon, const Element& element, int order,
                std::span<double> triangle);

// φ at p.
BasisValues evaluate_basis(std::span<const double> triangle, const Element& element, int order,
                           const Vec2& p);

// A node of a quadrature over an element; weights sum to 1.
struct Node {
  Vec2 p{0};
  double weight = 0;
};
inline constexpr int kMaxNodes = 9;
struct Rule {
  std::array<Node, kMaxNodes> nodes;
  int count = 0;
  bool exact_products = true;  // of two functions of the basis: orthonormal at the nodes
  // Of the square of a polynomial of one degree more than the basis has, and orthogonal to it, what
  // a fit at the nodes leaves over at the nodes, on the average over all such polynomials.
  double cubic_seen = 1;
  // From how far the fit misses the centre to the root mean square of what the nodes are blind to,
  // on the same average; 0: the centre tells nothing that the nodes do not.
  double bowl = 0;
};

// Nodes inside the element, positive weights.
// Orders 1 and 2: exact for polynomials of degree 2. 3 in a triangle, 2×2 Gauss mapped to a
// quadrilateral, 4 on the axes of inertia of any other polygon; 1 at the centroid for order 1 would
// be blind to where shadows fall, so that every order uses these.
// Order 3: exact for degree 5 in a triangle (7 [Radon 1948]) and in a parallelogram (8 [Burnside
// 1908]: unlike 3×3 Gauss, they see what a cubic leaves of a quadratic fit), for degree 4 in any
// other quadrilateral (3×3 Gauss), for degree 2 in any other polygon (4 on the axes of inertia of
// either half).
Rule quadrature(std::span<const Vec2> polygon, const Element& element, int order);

// Nodes that integrate the product of any two functions of the basis exactly: those of quadrature()
// where they do, else those of each triangle of a fan. Calls with(node).
template <class With>
void for_each_product_node(std::span<const Vec2> polygon, const Element& element, int order,
                           With&& with) {
  const Rule rule = quadrature(polygon, element, order);
  if (rule.exact_products) {
    for (const Node& node : std::span(rule.nodes).first(rule.count)) with(node);
    return;
  }
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const std::array<Vec2, 3> part{polygon[0], polygon[i - 1], polygon[i]};
    const Vec2 a = part[1] - part[0], b = part[2] - part[0];
    const double share = 0.5 * (a.x * b.y - a.y * b.x) / element.area;
    const Rule fine = quadrature(part, element, order);
    for (const Node& node : std::span(fine.nodes).first(fine.count))
      with(Node{node.p, share * node.weight});
  }
}

// Area, centroid and second moments (about the centroid, divided by area) of a convex polygon.
struct Moments {
  double area = 0;
  Vec2 centroid{0};
  double xx = 0, xy = 0, yy = 0;
};
Moments moments(std::span<const Vec2> polygon);

}  // namespace atrium
