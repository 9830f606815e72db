// The convex hull of points in a plane: Andrew's monotone chain. [Andrew 79]
// Pure; safe from any thread.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "engine/vec.h"

namespace atrium {

// Positive where the way from a through b to c turns left.
struct Turn {
  double operator()(const Vec2& a, const Vec2& b, const Vec2& c) const {
    const Vec2 u = b - a, v = c - b;
    return u.x * v.y - u.y * v.x;
  }
};

// Counter-clockwise from the point that is farthest left; none of the points on an edge but its
// ends, so that of points on one line there are two. `at` says of a point where it lies, with x and
// y, `turn` of three such places what Turn says.
template <class Point, class At = std::identity, class TurnOf = Turn>
std::vector<Point> convex_hull(std::vector<Point> points, At at = {}, TurnOf turn = {}) {
  std::vector<Point> hull;
  if (points.empty()) return hull;
  std::sort(points.begin(), points.end(), [&](const Point& p, const Point& q) {
    const auto &a = std::invoke(at, p), &b = std::invoke(at, q);
    return a.x != b.x ? a.x < b.x : a.y < b.y;
  });
  const auto place = [&](std::size_t from_last) -> decltype(auto) {
    return std::invoke(at, hull[hull.size() - from_last]);
  };
  const auto chain = [&](auto first, auto last) {
    const std::size_t base = hull.size();
    for (; first != last; ++first) {
      while (hull.size() >= base + 2 && !(turn(place(2), place(1), std::invoke(at, *first)) > 0))
        hull.pop_back();
      hull.push_back(*first);
    }
    hull.pop_back();  // the other chain begins with it
  };
  chain(points.begin(), points.end());
  chain(points.rbegin(), points.rend());
  return hull;
}

}  // namespace atrium
