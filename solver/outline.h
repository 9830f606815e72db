// Cutting convex outlines in a patch's frame by lines, for trees and for quadrature. Pure
// functions, any thread.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

using Outline = std::vector<Vec2>;  // convex, counter-clockwise

// A line in the patch's frame; left of it is where value() > 0.
struct Line {
  Vec2 normal{1, 0};
  double offset = 0;
  double value(const Vec2& p) const { return dot(normal, p) - offset; }
};

// The parts of a convex outline on either side; both get the same bits for the points between.
std::array<Outline, 2> cut(std::span<const Vec2> outline, const Line& line, double tolerance);

struct Extent {
  Vec2 lo, hi;
};
Extent extent_of(std::span<const Vec2> outline);

// Through the centroid, across the longer extent.
Line centroid_line(const Vec2& centroid, std::span<const Vec2> outline);

// The halves on either side of that line; the one with the lower coordinates first.
std::array<Outline, 2> halve(std::span<const Vec2> outline, const Vec2& centroid);

}  // namespace atrium
