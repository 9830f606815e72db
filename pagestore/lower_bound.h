// The least misses that any policy can have, for any foresight, and the fewest bytes that it can
// read: FOO. Each pair of consecutive
// requests for a record is an interval of time over which it may be kept, wholly or in part; what
// is kept at one time fits into the arena. The best such packing is a minimum cost flow along the
// line of requests. [Berger, Beckmann, Harchol-Balter, "Practical Bounds on Optimal Caching with
// Variable Object Sizes", SIGMETRICS 2018]
//
// Holds for traces with pins as well: pins and forced admission only take freedom away, and the
// interval of a record that changes its size begins with its last change. A record created in the
// trace may be kept from then on. Records larger than the arena are not kept, not even in part.
// Pure function; safe from any thread.
#pragma once

#include <cstdint>

#include "engine/status.h"
#include "pagestore/trace.h"

namespace atrium {

double lower_bound_misses(const Trace& trace, std::uint64_t arena, bool unit_size = false);

// Payload bytes that are read at the least, in a trace of ours.
struct LeastBytes {
  double in_this_order = 0;
  // Whatever the order of an iteration's gathers: each record that it asks for is read, at no less
  // than the smallest it is meanwhile, but for those that are there already, which fit the arena.
  std::uint64_t in_any_order = 0;
};
LeastBytes least_bytes(const Trace& trace, std::uint64_t arena,
                       std::uint64_t iteration = CountedPart::kAll);

}  // namespace atrium
