// Miss curve: misses and write-backs for every arena size, in one pass over a trace.
//
// LRU by release is a stack algorithm: a request hits in an arena of C bytes iff its distance, the
// bytes of the records released later than its own, or pinned, plus its own bytes, is at most C. A
// record is written back at C iff L <= C < distance, where L, its dirty level, is 0 when it is
// dirtied and max(L, distance) at each reload. [Mattson, Gecsei, Slutz, Traiger 1970; Thompson,
// Smith, TOCS 1989] Exact for arenas that hold the largest record and all that is pinned, and for
// records that do not shrink while they are in the arena; in traces without pins, for records that
// keep their size.
//
// Other policies are no stacks: they are simulated in miniature, on the records that a hash draws,
// in arenas scaled alike. [Waldspurger et al., FAST 15 and ATC 17]
// Pure functions; safe from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/trace.h"

namespace atrium {

struct CurvePoint {
  std::uint64_t arena = 0;  // bytes: what follows holds from here up to the next point
  std::uint64_t misses = 0, miss_bytes = 0;
  std::uint64_t writebacks = 0, writeback_bytes = 0;  // dirty victims; the final flush apart
  std::uint64_t final_flush = 0;
};

struct MissCurve {
  std::string policy;
  std::uint64_t requests = 0;
  std::uint64_t smallest_arena = 0;  // bytes: where the curve begins to hold
  double sample = 1;                 // share of the records that was looked at
  std::vector<CurvePoint> points;    // by arena, growing

  const CurvePoint& at(std::uint64_t arena) const;  // arena >= smallest_arena
};

// Exact.
MissCurve lru_curve(const Trace& trace, bool unit_size = false);

// An estimate from a share `sample` of the records: misses and bytes are scaled up to the whole
// trace, and so is the smallest arena, as the largest record has to fit into the sample's. LRU in
// one pass; other policies in `arenas` sizes, spread evenly in the logarithm. kUsage: no such
// policy, a trace with pins, no share, or one too small to draw a single record.
Result<MissCurve> sampled_curve(const Trace& trace, const std::string& policy, double sample,
                                bool unit_size = false, int arenas = 32);

}  // namespace atrium
