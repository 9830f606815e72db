// Extents: runs of granules, and the map of the free ones. The page file and the arena both
// allocate from a FreeMap, by best fit.
//
// Invariants of FreeMap:
//  1. Holes are disjoint and maximal: no two touch.
//  2. allocate takes from the smallest hole that is large enough, the lowest of equals, at its
//     lower end: the same calls give the same addresses.
// Not thread safe.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace atrium {

// A granule's address: in the arena its number, in the page file PageFile's segment and number.
inline constexpr std::uint64_t kNoGranule = std::numeric_limits<std::uint64_t>::max();

// A run of granules; none where it is empty.
struct Run {
  std::uint64_t first = kNoGranule;
  std::uint64_t granules = 0;
  bool exists() const { return granules > 0; }
};

class FreeMap {
 public:
  // Makes [first, first + granules) free; none of it may be.
  void free(std::uint64_t first, std::uint64_t granules);
  std::optional<std::uint64_t> allocate(std::uint64_t granules);
  // Takes just this run; false, and nothing taken, unless all of it is free.
  bool take(std::uint64_t first, std::uint64_t granules);

  std::uint64_t free_granules() const { return free_granules_; }
  std::uint64_t largest_hole() const { return by_size_.empty() ? 0 : by_size_.rbegin()->first; }

 private:
  using Holes = std::map<std::uint64_t, std::uint64_t>;  // first granule -> granules
  void insert(std::uint64_t first, std::uint64_t granules);
  void erase(Holes::iterator hole);

  Holes by_address_;
  std::set<std::pair<std::uint64_t, std::uint64_t>> by_size_;  // granules, first granule
  std::uint64_t free_granules_ = 0;
};

}  // namespace atrium
