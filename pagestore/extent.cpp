#include "pagestore/extent.h"

#include "engine/check.h"

namespace atrium {

void FreeMap::insert(std::uint64_t first, std::uint64_t granules) {
  by_address_.emplace(first, granules);
  by_size_.emplace(granules, first);
  free_granules_ += granules;
}

void FreeMap::erase(Holes::iterator hole) {
  by_size_.erase({hole->second, hole->first});
  free_granules_ -= hole->second;
  by_address_.erase(hole);
}

void FreeMap::free(std::uint64_t first, std::uint64_t granules) {
  ATRIUM_CHECK(granules > 0);
  auto after = by_address_.lower_bound(first);
  ATRIUM_CHECK(after == by_address_.end() || first + granules <= after->first);
  if (after != by_address_.end() && after->first == first + granules) {
    granules += after->second;
    auto next = std::next(after);
    erase(after);
    after = next;
  }
  if (after != by_address_.begin()) {
    const auto before = std::prev(after);
    ATRIUM_CHECK(before->first + before->second <= first);
    if (before->first + before->second == first) {
      first = before->first;
      granules += before->second;
      erase(before);
    }
  }
  insert(first, granules);
}

std::optional<std::uint64_t> FreeMap::allocate(std::uint64_t granules) {
  const auto best = by_size_.lower_bound({granules, 0});
  if (best == by_size_.end()) return std::nullopt;
  const std::uint64_t first = best->second;
  ATRIUM_CHECK(take(first, granules));
  return first;
}

bool FreeMap::take(std::uint64_t first, std::uint64_t granules) {
  ATRIUM_CHECK(granules > 0);
  auto hole = by_address_.upper_bound(first);
  if (hole == by_address_.begin()) return false;
  --hole;
  const auto [hole_first, hole_granules] = *hole;
  const std::uint64_t skipped = first - hole_first;
  if (skipped >= hole_granules || hole_granules - skipped < granules) return false;
  erase(hole);
  if (skipped > 0) insert(hole_first, skipped);
  const std::uint64_t left = hole_granules - skipped - granules;
  if (left > 0) insert(first + granules, left);
  return true;
}

}  // namespace atrium
