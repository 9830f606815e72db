// The packing against all packings of whole bytes: as the widths and the capacity are whole, so is
// a best flow.
#include "pagestore/interval_packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace atrium {
namespace {

// The best of `intervals` from number `next` on, in what room each place of the line has left.
double best_from(const std::vector<PackedInterval>& intervals, std::size_t next,
                 std::vector<std::uint64_t>& room) {
  if (next == intervals.size()) return 0;
  const PackedInterval& interval = intervals[next];
  const auto begin = room.begin() + interval.begin, end = room.begin() + interval.end;
  const std::uint64_t most = std::min(interval.bytes, *std::min_element(begin, end));
  double best = 0;
  for (std::uint64_t kept = 0; kept <= most; ++kept) {
    std::for_each(begin, end, [kept](std::uint64_t& bytes) { bytes -= kept; });
    const double share = static_cast<double>(kept) / static_cast<double>(interval.bytes);
    best = std::max(best, share + best_from(intervals, next + 1, room));
    std::for_each(begin, end, [kept](std::uint64_t& bytes) { bytes += kept; });
  }
  return best;
}

TEST(IntervalPacking, RandomIntervalsLikeTheBestInWholeBytes) {
  constexpr std::uint32_t kPlaces = 8;
  constexpr double kRounding = 1e-9;
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t capacity = 3 + random() % 6;
    std::vector<PackedInterval> intervals(random() % 8);
    for (PackedInterval& interval : intervals) {
      interval.begin = random() % (kPlaces - 1);
      interval.end = interval.begin + 1 + random() % (kPlaces - 1 - interval.begin);
      interval.bytes = 1 + random() % 3;
    }
    std::vector<std::uint64_t> room(kPlaces, capacity);
    ASSERT_NEAR(largest_packing(intervals, capacity), best_from(intervals, 0, room), kRounding)
        << "case " << i;
  }
}

TEST(IntervalPacking, NoIntervals) { EXPECT_EQ(largest_packing({}, 5), 0); }

TEST(IntervalPacking, NoBytesAreAlwaysKept) {
  EXPECT_EQ(largest_packing({{0, 3, 0}, {1, 2, 0}, {0, 2, 1}}, 0), 2);
}

// Sizes that differ by 2^40, with prices that differ as much: the small ones are kept all the same.
TEST(IntervalPacking, HugeBesideTiny) {
  constexpr std::uint64_t kHuge = std::uint64_t{1} << 40;
  EXPECT_NEAR(largest_packing({{0, 4, kHuge}, {0, 4, 1}, {1, 3, 1}}, kHuge), 3, 1e-6);
  EXPECT_NEAR(largest_packing({{0, 4, kHuge}, {0, 4, kHuge}, {1, 3, 2}}, kHuge), 2, 1e-6);
}

}  // namespace
}  // namespace atrium
