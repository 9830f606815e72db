// Trace: what was asked of a store, in order: the one thing that simulation, miss curves, bounds
// and replay work on. It comes from a file (pagestore/trace_file.h) or from a test.
//
// Two kinds. A trace of ours pins: a record is read, perhaps dirtied, and released, between marks
// of gathers, iterations and checkpoints; sizes are charged to the arena as the store charges them.
// A trace from elsewhere has requests only, each of them released at once, and its sizes are
// charged as they stand. Plain data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/policy.h"

namespace atrium {

enum class TraceOp : std::uint8_t {
  kRead,        // a request; the record is pinned once more
  kDirty,       // a pinned record is dirty from here on and `bytes` long
  kRelease,     // one pin less
  kCreate,      // the record comes into being in the arena, dirty and not pinned: no request
  kGet,         // a request, released at once; brought in, it is `bytes` long
  kPut,         // likewise, and dirty
  kGather,      // the gather to `record` begins; what follows up to the next mark is its own
  kIteration,   // iteration number `bytes` begins; kBetweenIterations: the last one is over
  kCheckpoint,  // every dirty record is written and stays where it is
};

constexpr bool is_request(TraceOp op) {
  return op == TraceOp::kRead || op == TraceOp::kGet || op == TraceOp::kPut;
}

inline constexpr std::uint64_t kBetweenIterations = 0;

struct TraceEvent {
  TraceOp op;
  RecordNumber record = 0;  // 0 for marks without one
  std::uint64_t bytes = 0;  // payload bytes of the record after this event; kIteration: its number
};

struct Trace {
  bool pins = false;  // ours: kRead, kDirty, kRelease, kCreate and marks; else kGet, kPut
  std::vector<std::uint64_t> ids;    // by record number: what the trace calls it
  std::vector<std::uint64_t> sizes;  // by record number: payload bytes when the trace begins; of
                                     // records created in it, and of traces without pins: 0
  std::vector<TraceEvent> events;
  std::vector<std::uint32_t> times;  // of traces without pins: seconds, an event; else empty
};

// Bytes of the arena that a record takes: in a trace of ours header and whole granules, else as is;
// 1 where `unit_size`.
std::uint64_t arena_charge(const Trace& trace, std::uint64_t payload_bytes, bool unit_size);

std::uint64_t request_count(const Trace& trace);

// What of a trace is counted: one iteration, or all of it.
class CountedPart {
 public:
  static constexpr std::uint64_t kAll = ~std::uint64_t{0};
  explicit CountedPart(std::uint64_t iteration = kAll)
      : here(iteration == kAll), iteration_(iteration) {}
  void pass(const TraceEvent& event) {
    if (iteration_ == kAll || event.op != TraceOp::kIteration) return;
    here = event.bytes == iteration_;
  }
  bool here;  // after the events that were passed

 private:
  std::uint64_t iteration_;
};

// Can this have been asked of a store? kUsage, naming the event, if it is of a record without a
// number, of the other kind of trace, if it dirties or releases what is not pinned, or creates what
// is there. What follows here, and simulation, holds for sound traces.
Status check_trace(const Trace& trace);

// For each request, by its number from 0: the number of its record's next request, kNeverAgain if
// there is none.
inline constexpr std::uint64_t kNeverAgain = ~std::uint64_t{0};
std::vector<std::uint64_t> next_requests(const Trace& trace);

// The smallest arena that holds, at every moment, what is pinned and what is just being created: of
// a trace without pins, its largest record.
std::uint64_t smallest_feasible_arena(const Trace& trace, bool unit_size);

// The recorded gathers in another order, within each iteration; the requests stay the same in kind
// and number, and sizes follow the new order. What is between an iteration's gathers, checkpoints
// for one, stays between the same two places. Orders: recorded, reverse, model (by the receiver's
// id), random, nearest (each next gather the one that has most records in common with the last
// one). kUsage: no such order, a trace without gathers, or gathers that cannot be parted.
std::vector<std::string> reorder_names();
Result<Trace> reorder(const Trace& trace, const std::string& order, std::uint64_t seed);

}  // namespace atrium
