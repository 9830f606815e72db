// The basis of an element: polynomials of total degree below `order` in the plane, orthonormal over
// the element in the mean: (1/A) ∫ φi φj = δij. φ0 = 1, so coefficient 0 is the element's mean.
// Multiwavelets on an arbitrary convex element: a child's space holds its parent's, so that push is
// exact and pull is the L2 projection. [GSCH93, Alpert]
//
// A basis is stored as the lower triangle L of φ = L m with the monomials
// m = (1, x, y, ...) in x = (p - centroid) / radius. Pure functions, any thread.
#pragma once

#include <array>
#include <span>

#include "engine/element.h"

namespace atrium {

using BasisValues = std::array<double, kMaxCoefficients>;

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
inline constexpr int kMaxNodes = 4;
struct Rule {
  std::array<Node, kMaxNodes> nodes;
  int count = 0;
};

// Nodes inside the element, exact for polynomials of degree 2: 3 in a triangle, 2×2 Gauss mapped
// to a quadrilateral, 4 on the axes of inertia of any other polygon; 1 at the centroid for order 1
// would be blind to where shadows fall, so that every order uses these.
Rule quadrature(std::span<const Vec2> polygon, const Element& element);

// Area, centroid and second moments (about the centroid, divided by area) of a convex polygon.
struct Moments {
  double area = 0;
  Vec2 centroid{0};
  double xx = 0, xy = 0, yy = 0;
};
Moments moments(std::span<const Vec2> polygon);

}  // namespace atrium
