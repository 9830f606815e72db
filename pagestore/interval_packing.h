// Interval packing: which intervals of a line, each as wide as its bytes, to keep so that those
// over one place never exceed a capacity; parts of an interval may be kept. It is the heart of the
// lower bound (pagestore/lower_bound.h). Pure functions; safe from any thread.
#pragma once

#include <cstdint>
#include <vector>

namespace atrium {

struct PackedInterval {
  std::uint32_t begin = 0,
                end = 0;  // places of the line, begin < end: it takes room over [begin, end)
  std::uint64_t bytes = 0;
  std::uint64_t worth = 1;  // of keeping it whole; at most its bytes
};

// The greatest sum of what the kept shares are worth, each share between 0 and 1. An interval
// counts for its worth or a little more: by no more than places * its bytes / the fewest bytes a
// worth of an interval / 2^60.
double largest_packing(const std::vector<PackedInterval>& intervals, std::uint64_t capacity);

}  // namespace atrium
