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

bool resizes(TraceOp op) { return op == TraceOp::kDirty || op == TraceOp::kCreate; }

enum class Worth { kOne, kPayload };  // of a request that need not be read

// Those that end in the part that counts.
std::vector<PackedInterval> intervals_of(const Trace& trace, bool unit_size, Worth worth,
                                         CountedPart part) {
  std::vector<Kept> records(trace.ids.size());
  std::vector<std::uint64_t> payload = trace.sizes;
  for (std::size_t i = 0; i < records.size(); ++i)
    records[i].bytes = arena_charge(trace, trace.sizes[i], unit_size);
  std::vector<PackedInterval> intervals;
  std::uint32_t place = 0;
  for (const TraceEvent& event : trace.events) {
    part.pass(event);
    if (!concerns_record(event.op)) continue;
    if (resizes(event.op)) payload[event.record] = event.bytes;
    Kept& kept = records[event.record];
    const bool seen = kept.since != Kept::kNever;
    const std::uint64_t bytes = arena_charge(trace, event.bytes, unit_size);
    if (is_request(event.op) && seen && part.here)
      intervals.push_back({kept.since, place, kept.bytes,
                           worth == Worth::kOne ? 1 : payload[event.record]});
    if (event.op == TraceOp::kCreate) kept = {place++, bytes};
    if (event.op == TraceOp::kRead) kept.since = place++;
    if (event.op == TraceOp::kDirty && bytes != kept.bytes) kept = {place - 1, bytes};
    if (event.op == TraceOp::kGet || event.op == TraceOp::kPut)
      kept = {place++, seen ? std::min(kept.bytes, bytes) : bytes};
  }
  return intervals;
}

std::uint64_t requested_bytes(const Trace& trace, CountedPart part) {
  std::vector<std::uint64_t> payload = trace.sizes;
  std::uint64_t sum = 0;
  for (const TraceEvent& event : trace.events) {
    part.pass(event);
    if (resizes(event.op)) payload[event.record] = event.bytes;
    if (is_request(event.op) && part.here) sum += payload[event.record];
  }
  return sum;
}

// Sums over iterations, and what is between them, what each must read in any order.
class InAnyOrder {
 public:
  InAnyOrder(const Trace& trace, std::uint64_t arena)
      : arena_(arena), payload_(trace.sizes), least_(trace.sizes), asked_(trace.ids.size()) {}

  void pass(const TraceEvent& event, bool counts) {
    if (event.op == TraceOp::kIteration) end_iteration();
    if (is_request(event.op) && counts) asked_[event.record] = true;
    if (!resizes(event.op)) return;
    payload_[event.record] = event.bytes;
    least_[event.record] = std::min(least_[event.record], event.bytes);
  }
  std::uint64_t sum() {
    end_iteration();
    return sum_;
  }

 private:
  void end_iteration() {
    std::uint64_t bytes = 0;
    for (std::size_t r = 0; r < asked_.size(); ++r) bytes += asked_[r] ? least_[r] : 0;
    sum_ += bytes > arena_ ? bytes - arena_ : 0;
    least_ = payload_;
    asked_.assign(asked_.size(), false);
  }

  const std::uint64_t arena_;
  std::uint64_t sum_ = 0;
  std::vector<std::uint64_t> payload_, least_;  // by record: now; since the iteration began
  std::vector<bool> asked_;                     // in this iteration
};

}  // namespace

double lower_bound_misses(const Trace& trace, std::uint64_t arena, bool unit_size) {
  const double kept =
      largest_packing(intervals_of(trace, unit_size, Worth::kOne, CountedPart()), arena);
  return static_cast<double>(request_count(trace)) - kept;
}

LeastBytes least_bytes(const Trace& trace, std::uint64_t arena, std::uint64_t iteration) {
  CountedPart part(iteration);
  InAnyOrder any(trace, arena);
  for (const TraceEvent& event : trace.events) {
    part.pass(event);
    any.pass(event, part.here);
  }
  const CountedPart from_the_start(iteration);
  const double kept = largest_packing(
      intervals_of(trace, false, Worth::kPayload, from_the_start), arena);
  return {static_cast<double>(requested_bytes(trace, from_the_start)) - kept, any.sum()};
}

}  // namespace atrium
