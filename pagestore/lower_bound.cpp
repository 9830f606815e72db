#include "pagestore/lower_bound.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "pagestore/interval_packing.h"

namespace atrium {
namespace {

// What a record takes if it is kept from its last request, or its creation, on. In a trace of ours
// the interval begins where its size last changed: it takes that much until its next request. In
// one from elsewhere a record keeps the size it was brought in with, whenever that was: no less
// than the smallest it has been asked for with.
struct Kept {
  static constexpr std::uint32_t kNever = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t since = kNever;  // the place in the line of requests and creations
  std::uint64_t bytes = 0;       // of the arena
};

bool concerns_record(TraceOp op) {
  return is_request(op) || op == TraceOp::kDirty || op == TraceOp::kCreate;
}

std::vector<PackedInterval> intervals_of(const Trace& trace, bool unit_size) {
  std::vector<Kept> records(trace.ids.size());
  for (std::size_t i = 0; i < records.size(); ++i)
    records[i].bytes = arena_charge(trace, trace.sizes[i], unit_size);
  std::vector<PackedInterval> intervals;
  std::uint32_t place = 0;
  for (const TraceEvent& event : trace.events) {
    if (!concerns_record(event.op)) continue;
    Kept& kept = records[event.record];
    const bool seen = kept.since != Kept::kNever;
    const std::uint64_t bytes = arena_charge(trace, event.bytes, unit_size);
    if (is_request(event.op) && seen) intervals.push_back({kept.since, place, kept.bytes});
    if (event.op == TraceOp::kCreate) kept = {place++, bytes};
    if (event.op == TraceOp::kRead) kept.since = place++;
    if (event.op == TraceOp::kDirty && bytes != kept.bytes) kept = {place - 1, bytes};
    if (event.op == TraceOp::kGet || event.op == TraceOp::kPut)
      kept = {place++, seen ? std::min(kept.bytes, bytes) : bytes};
  }
  return intervals;
}

}  // namespace

double lower_bound_misses(const Trace& trace, std::uint64_t arena, bool unit_size) {
  const double kept = largest_packing(intervals_of(trace, unit_size), arena);
  return static_cast<double>(request_count(trace)) - kept;
}

}  // namespace atrium
