// Convex outlines that the tests of bases and trees go through.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include "engine/vec.h"

namespace atrium::testing {

struct Shape {
  std::string name;
  std::vector<Vec2> outline;
  double aspect = 1;  // length ÷ width, about
};

inline std::vector<Vec2> regular(int corners, double radius) {
  std::vector<Vec2> outline;
  for (int i = 0; i < corners; ++i) {
    const double a = 2 * std::numbers::pi * i / corners;
    outline.push_back({radius * std::cos(a), radius * std::sin(a)});
  }
  return outline;
}

inline std::vector<Vec2> moved(std::vector<Vec2> outline, double scale, double degrees,
                               const Vec2& by) {
  const double a = degrees * std::numbers::pi / 180, c = std::cos(a), s = std::sin(a);
  for (Vec2& p : outline) p = by + scale * Vec2{c * p.x - s * p.y, s * p.x + c * p.y};
  return outline;
}

inline std::vector<Shape> shapes() {
  return {
      {"right triangle", {{0, 0}, {3, 0}, {0, 2}}, 2},
      {"needle triangle", {{0, 0}, {1000, 0}, {600, 1}}, 1000},
      {"needle triangle turned 45 degrees", moved({{0, 0}, {1000, 0}, {600, 1}}, 1, 45, {0, 0}),
       1000},
      {"unit square", {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1},
      {"trapezoid", {{0, 0}, {4, 0}, {3, 1}, {1, 1}}, 4},
      {"crooked quadrilateral", {{0, 0}, {5, 1}, {4, 4}, {-1, 2}}, 2},
      {"needle rectangle turned 30 degrees",
       moved({{0, 0}, {1000, 0}, {1000, 1}, {0, 1}}, 1, 30, {0, 0}), 1000},
      {"regular hexagon", regular(6, 1), 1},
      {"crooked hexagon", {{0, 0}, {2, -1}, {5, 0}, {5.5, 2}, {3, 4}, {0, 3}}, 1.5},
      {"pentagon, nearly a triangle", {{0, 0}, {2, -1e-4}, {4, 0}, {2, 3}, {0.9999, 1.5001}}, 1.5},
      {"regular dodecagon far from the origin", moved(regular(12, 1), 1, 7, {1e3, -2e3}), 1},
  };
}

}  // namespace atrium::testing
