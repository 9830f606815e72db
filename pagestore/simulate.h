// Simulation: a trace against a policy and an arena, counted exactly and without touching a byte.
// The counts are those of the live store under the same requests (pagestore/replay.h checks).
//
// Rules. A request for a record in the arena is a hit, any other a miss. A miss brings the record
// in: while what is there and what is coming exceed the arena, the policy's victim leaves, written
// back first if it is dirty. Pinned records are charged and stay. A record that grows is charged
// when it is dirtied, others leaving for it; one that is created comes in dirty and is no request.
// Of a trace without pins: a record larger than the arena, or not admitted by the policy, is a miss
// that changes nothing, and the size of a record in the arena stays that of the request that
// brought it in. A policy with foresight is told of a next request as soon as that is within its
// reach of the last request begun, before room is made for that one.
// Where one iteration is counted, what came before it has filled the arena.
// Pure functions; safe from any thread.
#pragma once

#include <cstdint>
#include <string>

#include "engine/status.h"
#include "pagestore/trace.h"

namespace atrium {

// What a read or a write costs: latency + bytes / bandwidth. [facts: the paper's Table 4]
struct DiskModel {
  double seconds_per_operation = 100e-6;
  double bandwidth = 1e9;  // bytes a second
};

struct Simulation {
  std::string policy;
  std::uint64_t arena = 0;  // bytes; records where sizes are 1
  bool feasible = true;     // false: what is pinned exceeds the arena; all counts are 0
  std::uint64_t requests = 0, hits = 0, misses = 0;
  std::uint64_t miss_bytes = 0;  // payload, as all bytes here
  std::uint64_t evictions = 0;
  std::uint64_t writebacks = 0, writeback_bytes = 0;  // dirty victims
  std::uint64_t checkpoint_writes = 0, checkpoint_bytes = 0;  // by checkpoints with requests after them
  std::uint64_t final_flush = 0, final_flush_bytes = 0;  // dirty after the last request
  std::uint64_t min_feasible_arena = 0;                  // bytes
  double seconds = 0;  // modelled
};

// kUsage: no such policy, or a trace that is not sound (check_trace).
Result<Simulation> simulate(const Trace& trace, const std::string& policy, std::uint64_t arena,
                            bool unit_size = false, const DiskModel& disk = {},
                            std::uint64_t iteration = CountedPart::kAll);

}  // namespace atrium
