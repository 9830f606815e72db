// Cubature over triangles of what is positive and smooth there, and the cutting of polygons into
// such triangles: for form factors so small beside the contour's terms that these cancel.
// Pure functions, any thread.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "engine/geometry.h"
#include "solver/gauss.h"

namespace atrium {

using Triangle = std::array<Vec3, 3>;

// Cuts a simple polygon, concave ones too, by ear clipping; triangles turn as the polygon does.
// False if no ear is found: the polygon crosses itself.
bool triangulate(PolygonView polygon, std::vector<Triangle>& out);

// The part of the triangles in front of the plane, in triangles.
std::vector<Triangle> clip(std::span<const Triangle> triangles, const Plane& plane,
                           double tolerance);

double area(const Triangle& t);
double longest_edge(const Triangle& t);
std::pair<Triangle, Triangle> bisect(const Triangle& t);  // the longest edge

// Nodes of a triangle, kNodes² of them, and weights that sum to 1: exact for degree 2 kNodes - 2.
template <int kNodes>
struct TriangleRule {
  std::array<Vec3, kNodes * kNodes> at;
  std::array<double, kNodes * kNodes> weight;
  explicit TriangleRule(const Triangle& t) {
    for (int i = 0; i < kNodes; ++i) {
      const double u = Gauss<kNodes>::node[i];
      for (int j = 0; j < kNodes; ++j) {
        const double v = Gauss<kNodes>::node[j];
        at[i * kNodes + j] = t[0] + u * ((t[1] - t[0]) + v * (t[2] - t[1]));
        weight[i * kNodes + j] = 2 * u * Gauss<kNodes>::weight[i] * Gauss<kNodes>::weight[j];
      }
    }
  }
};

// How far the rule of 5 may be off, from how far that of 3 is off it: where the integrand is smooth
// enough for either, their errors go with the 9th and the 5th power of the piece's size.
inline double error_of_finer(double coarse, double fine) {
  const double difference = std::abs(fine - coarse);
  if (!(difference < std::abs(fine))) return difference;
  return std::abs(fine) * std::pow(difference / std::abs(fine), 9.0 / 5.0);
}

}  // namespace atrium
