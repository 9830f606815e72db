#include "engine/import/ears.h"

#include <numeric>

namespace atrium {
namespace {

// Seen along the polygon's mean normal: does the corner turn left, and is it clear of the others?
bool is_ear(PolygonView p, const std::vector<std::uint32_t>& left, std::size_t i, const Vec3& n) {
  const std::size_t size = left.size();
  const std::uint32_t ia = left[(i + size - 1) % size], ib = left[i], ic = left[(i + 1) % size];
  const Vec3 &a = p[ia], &b = p[ib], &c = p[ic];
  const auto side = [&](const Vec3& from, const Vec3& to, const Vec3& x) {
    return dot(n, cross(to - from, x - from));
  };
  if (!(side(a, b, c) > 0)) return false;
  for (const std::uint32_t j : left) {
    if (j == ia || j == ib || j == ic || p[j] == a || p[j] == b || p[j] == c) continue;
    if (side(a, b, p[j]) >= 0 && side(b, c, p[j]) >= 0 && side(c, a, p[j]) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> clip_ears(PolygonView polygon) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> left(polygon.size());
  std::iota(left.begin(), left.end(), 0u);
  const Vec3 normal = area_vector(polygon);
  while (left.size() >= 3) {
    const std::size_t n = left.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(polygon, left, ear, normal)) ++ear;
    // A polygon that crosses itself may have no ear: its first corner goes, so that it ends.
    if (ear == n) ear = 0;
    triangles.push_back({left[(ear + n - 1) % n], left[ear], left[(ear + 1) % n]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

}  // namespace atrium
