#include "solver/outline.h"

#include <algorithm>
#include <utility>

namespace atrium {

namespace {

// Extents this near each other, relative, are equal: a shifted copy must split alike.
constexpr double kTie = 1e-9;

}  // namespace

std::array<Outline, 2> cut(std::span<const Vec2> outline, const Line& line, double tolerance) {
  std::array<Outline, 2> parts;
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 &a = outline[i], &b = outline[(i + 1) % n];
    const double da = line.value(a), db = line.value(b);
    if (da >= -tolerance) parts[0].push_back(a);
    if (da <= tolerance) parts[1].push_back(a);
    if ((da > tolerance && db < -tolerance) || (da < -tolerance && db > tolerance)) {
      const Vec2 x = a + (b - a) * (da / (da - db));
      parts[0].push_back(x);
      parts[1].push_back(x);
    }
  }
  return parts;
}

Extent extent_of(std::span<const Vec2> outline) {
  Extent e{outline[0], outline[0]};
  for (const Vec2& p : outline) {
    e.lo = {std::min(e.lo.x, p.x), std::min(e.lo.y, p.y)};
    e.hi = {std::max(e.hi.x, p.x), std::max(e.hi.y, p.y)};
  }
  return e;
}

Line centroid_line(const Vec2& centroid, std::span<const Vec2> outline) {
  const Extent e = extent_of(outline);
  const Vec2 size = e.hi - e.lo;
  const Vec2 normal = size.x * (1 + kTie) >= size.y ? Vec2{1, 0} : Vec2{0, 1};
  return {normal, dot(normal, centroid)};
}

std::array<Outline, 2> halve(std::span<const Vec2> outline, const Vec2& centroid) {
  std::array<Outline, 2> parts = cut(outline, centroid_line(centroid, outline), 0);
  std::swap(parts[0], parts[1]);
  return parts;
}

}  // namespace atrium
