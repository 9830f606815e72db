#include "pagestore/trace.h"

#include <algorithm>

#include "pagestore/record.h"

namespace atrium {

namespace {

// What a trace says of one record, up to some event.
struct Life {
  std::uint32_t pins = 0;
  bool seen = false;
};

bool of_pinned_traces(TraceOp op) { return op != TraceOp::kGet && op != TraceOp::kPut; }

// What is wrong with an event; nullptr if nothing. `life`: of its record.
const char* event_fault(const Trace& trace, const TraceEvent& event, const Life& life) {
  if (of_pinned_traces(event.op) != trace.pins)
    return trace.pins ? "a get or put in a trace with pins" : "pins or marks in a trace without";
  const bool needs_pin = event.op == TraceOp::kDirty || event.op == TraceOp::kRelease;
  if (needs_pin && life.pins == 0) return "the record is not pinned";
  if (event.op == TraceOp::kCreate && life.seen) return "a record is created that is there already";
  return nullptr;
}

void live_on(Life& life, TraceOp op) {
  if (op == TraceOp::kRead) ++life.pins;
  if (op == TraceOp::kRelease) --life.pins;
  life.seen = life.seen || is_request(op) || op == TraceOp::kCreate;
}

Status unsound(std::size_t event, const std::string& cause) {
  return Status(Code::kUsage, "trace", "event " + std::to_string(event), cause,
                "record the trace again");
}

}  // namespace

Status check_trace(const Trace& trace) {
  const std::size_t records = trace.ids.size();
  if (trace.sizes.size() != records) return unsound(0, "not as many sizes as records");
  std::vector<Life> lives(records + 1);  // the last: of marks without a record
  for (std::size_t i = 0; i < trace.events.size(); ++i) {
    const TraceEvent& event = trace.events[i];
    const bool mark = event.op == TraceOp::kIteration || event.op == TraceOp::kCheckpoint;
    if (!mark && event.record >= records) return unsound(i, "there is no record of that number");
    Life& life = lives[mark ? records : event.record];
    if (const char* fault = event_fault(trace, event, life)) return unsound(i, fault);
    live_on(life, event.op);
  }
  return {};
}

std::uint64_t arena_charge(const Trace& trace, std::uint64_t payload_bytes, bool unit_size) {
  if (unit_size) return 1;
  return trace.pins ? granules_of(payload_bytes) * kGranule : payload_bytes;
}

std::uint64_t request_count(const Trace& trace) {
  return static_cast<std::uint64_t>(std::ranges::count_if(
      trace.events, [](const TraceEvent& event) { return is_request(event.op); }));
}

std::vector<std::uint64_t> next_requests(const Trace& trace) {
  std::vector<std::uint64_t> next(request_count(trace));
  std::vector<std::uint64_t> next_of_record(trace.ids.size(), kNeverAgain);
  std::uint64_t request = next.size();
  for (auto event = trace.events.rbegin(); event != trace.events.rend(); ++event) {
    if (!is_request(event->op)) continue;
    --request;
    next[request] = next_of_record[event->record];
    next_of_record[event->record] = request;
  }
  return next;
}

std::uint64_t smallest_feasible_arena(const Trace& trace, bool unit_size) {
  std::vector<std::uint64_t> payload = trace.sizes;
  std::vector<std::uint32_t> pins(trace.ids.size(), 0);
  std::uint64_t pinned = 0, most = 0;
  for (const TraceEvent& event : trace.events) {
    const RecordNumber r = event.record;
    std::uint64_t passing = 0;  // in the arena for this event alone
    switch (event.op) {
      case TraceOp::kRead:
        if (pins[r]++ == 0) pinned += arena_charge(trace, payload[r], unit_size);
        break;
      case TraceOp::kDirty:
        pinned -= arena_charge(trace, payload[r], unit_size);
        payload[r] = event.bytes;
        pinned += arena_charge(trace, payload[r], unit_size);
        break;
      case TraceOp::kRelease:
        if (--pins[r] == 0) pinned -= arena_charge(trace, payload[r], unit_size);
        break;
      case TraceOp::kCreate:
        payload[r] = event.bytes;
        [[fallthrough]];
      case TraceOp::kGet:
      case TraceOp::kPut:
        passing = arena_charge(trace, event.bytes, unit_size);
        break;
      case TraceOp::kGather:
      case TraceOp::kIteration:
      case TraceOp::kCheckpoint:
        break;
    }
    most = std::max(most, pinned + passing);
  }
  return most;
}

}  // namespace atrium
