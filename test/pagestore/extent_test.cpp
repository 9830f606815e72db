#include "pagestore/extent.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace atrium {
namespace {

TEST(FreeMap, TakesTheSmallestHoleThatIsLargeEnoughAndTheLowestOfEquals) {
  FreeMap map;
  map.free(0, 10);
  map.free(20, 4);
  map.free(40, 4);
  map.free(60, 6);
  EXPECT_EQ(map.allocate(4), 20u);
  EXPECT_EQ(map.allocate(3), 40u);
  EXPECT_EQ(map.allocate(1), 43u);
  EXPECT_EQ(map.allocate(7), 0u);
  EXPECT_EQ(map.allocate(7), std::nullopt);
  EXPECT_EQ(map.largest_hole(), 6u);
  EXPECT_EQ(map.free_granules(), 3u + 6u);
}

TEST(FreeMap, NeighboursBecomeOneHole) {
  FreeMap map;
  map.free(0, 2);
  map.free(4, 2);
  map.free(2, 2);
  EXPECT_EQ(map.largest_hole(), 6u);
  EXPECT_TRUE(map.take(1, 4));
  EXPECT_EQ(map.largest_hole(), 1u);
  EXPECT_FALSE(map.take(0, 2));  // half of it is taken
  EXPECT_FALSE(map.take(5, 2));  // runs past the end
  EXPECT_FALSE(map.take(9, 1));  // was never there
  EXPECT_EQ(map.free_granules(), 2u);
}

// The same calls on a row of flags, where best fit is a plain scan.
TEST(FreeMap, AgreesWithAScanOverFlags) {
  constexpr std::uint64_t kGranules = 200;
  std::vector<bool> is_free(kGranules, true);
  FreeMap map;
  map.free(0, kGranules);
  std::mt19937_64 random(1);
  std::vector<std::pair<std::uint64_t, std::uint64_t>> taken;
  for (int step = 0; step < 20'000; ++step) {
    if (random() % 2 == 0 && !taken.empty()) {
      const std::size_t i = random() % taken.size();
      const auto [first, granules] = taken[i];
      taken.erase(taken.begin() + static_cast<std::ptrdiff_t>(i));
      map.free(first, granules);
      for (std::uint64_t g = first; g < first + granules; ++g) is_free[g] = true;
      continue;
    }
    const std::uint64_t granules = 1 + random() % 20;
    std::optional<std::uint64_t> best;
    std::uint64_t best_size = kGranules + 1;
    for (std::uint64_t g = 0; g < kGranules;) {
      std::uint64_t end = g;
      while (end < kGranules && is_free[end]) ++end;
      if (end - g >= granules && end - g < best_size) {
        best = g;
        best_size = end - g;
      }
      g = end + 1;
    }
    ASSERT_EQ(map.allocate(granules), best);
    if (!best) continue;
    taken.emplace_back(*best, granules);
    for (std::uint64_t g = *best; g < *best + granules; ++g) is_free[g] = false;
  }
  std::uint64_t free_count = 0;
  for (const bool f : is_free) free_count += f ? 1 : 0;
  EXPECT_EQ(map.free_granules(), free_count);
}

}  // namespace
}  // namespace atrium
