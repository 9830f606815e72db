#include "engine/import/weld.h"

#include <cmath>

namespace atrium {
namespace {

constexpr std::uint32_t kNone = 0xffffffff;
// Grid cubes this many distances wide: a point near a wall of its cube is rare.
constexpr double kCubeWidth = 8;
// Models love round coordinates: shifted, the cubes' walls do not lie on them.
constexpr double kShift = 0.37;

}  // namespace

std::size_t Welder::Hash::operator()(const std::array<std::int64_t, 3>& c) const noexcept {
  std::uint64_t h = 0;
  for (const std::int64_t k : c) {
    h ^= static_cast<std::uint64_t>(k) + 0x9e3779b97f4a7c15ull + (h << 6) + (h >> 2);
    h *= 0xbf58476d1ce4e5b9ull;
    h ^= h >> 29;
  }
  return h;
}

std::uint32_t Welder::weld(const Vec3& x) {
  const double cube = kCubeWidth * distance_;
  std::array<std::int64_t, 3> lo, hi, home;
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    lo[i] = static_cast<std::int64_t>(std::floor((x[k] - distance_) / cube + kShift));
    hi[i] = static_cast<std::int64_t>(std::floor((x[k] + distance_) / cube + kShift));
    home[i] = static_cast<std::int64_t>(std::floor(x[k] / cube + kShift));
  }
  std::uint32_t best = kNone;
  for (std::int64_t i = lo[0]; i <= hi[0]; ++i)
    for (std::int64_t j = lo[1]; j <= hi[1]; ++j)
      for (std::int64_t k = lo[2]; k <= hi[2]; ++k) {
        const auto chain = first_.find({i, j, k});
        if (chain == first_.end()) continue;
        for (std::uint32_t p = chain->second; p != kNone; p = next_[p])
          if (p < best && length(points_[p] - x) <= distance_) best = p;
      }
  if (best != kNone) return best;
  const auto index = static_cast<std::uint32_t>(points_.size());
  const auto [chain, added] = first_.try_emplace(home, kNone);
  points_.push_back(x);
  next_.push_back(chain->second);
  chain->second = index;
  return index;
}

}  // namespace atrium
