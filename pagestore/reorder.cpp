// Gathers of a trace in another order. A gather is the run of events from its mark up to the next
// mark; all else stays where it is.
#include <algorithm>
#include <numeric>
#include <random>
#include <span>

#include "pagestore/trace.h"

namespace atrium {

namespace {

struct Gather {
  std::size_t first, last;  // events, the mark included; one past the last
};

using Sequence =
    std::vector<std::size_t>;  // of gathers, by their places among those of one iteration

bool is_mark(TraceOp op) {
  return op == TraceOp::kGather || op == TraceOp::kIteration || op == TraceOp::kCheckpoint;
}

std::span<const TraceEvent> events_of(const Trace& trace, const Gather& gather) {
  return std::span(trace.events).subspan(gather.first, gather.last - gather.first);
}

// Iteration by iteration.
std::vector<std::vector<Gather>> gathers_of(const Trace& trace) {
  std::vector<std::vector<Gather>> iterations(1);
  const auto& events = trace.events;
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].op == TraceOp::kIteration) iterations.emplace_back();
    if (events[i].op != TraceOp::kGather) continue;
    std::size_t last = i + 1;
    while (last < events.size() && !is_mark(events[last].op)) ++last;
    iterations.back().push_back({i, last});
  }
  return iterations;
}

Sequence recorded_order(const Trace&, std::span<const Gather> gathers, std::uint64_t) {
  Sequence sequence(gathers.size());
  std::iota(sequence.begin(), sequence.end(), std::size_t{0});
  return sequence;
}

Sequence reverse_order(const Trace& trace, std::span<const Gather> gathers, std::uint64_t seed) {
  Sequence sequence = recorded_order(trace, gathers, seed);
  std::ranges::reverse(sequence);
  return sequence;
}

Sequence model_order(const Trace& trace, std::span<const Gather> gathers, std::uint64_t seed) {
  Sequence sequence = recorded_order(trace, gathers, seed);
  std::ranges::stable_sort(sequence, {}, [&](std::size_t gather) {
    return trace.ids[trace.events[gathers[gather].first].record];
  });
  return sequence;
}

Sequence random_order(const Trace& trace, std::span<const Gather> gathers, std::uint64_t seed) {
  Sequence sequence = recorded_order(trace, gathers, seed);
  std::mt19937_64 draw(seed);  // the same on every machine, as std::shuffle is not
  for (std::size_t i = sequence.size(); i > 1; --i)
    std::swap(sequence[i - 1], sequence[draw() % i]);
  return sequence;
}

// The records that each gather requests, without repetition.
std::vector<std::vector<RecordNumber>> working_sets(const Trace& trace,
                                                    std::span<const Gather> gathers) {
  std::vector<std::vector<RecordNumber>> sets;
  for (const Gather& gather : gathers) {
    std::vector<RecordNumber> set;
    for (const TraceEvent& event : events_of(trace, gather))
      if (is_request(event.op)) set.push_back(event.record);
    std::ranges::sort(set);
    set.erase(std::ranges::unique(set).begin(), set.end());
    sets.push_back(std::move(set));
  }
  return sets;
}

// From the first recorded one on; ties go to the one recorded first. Only gathers that share a
// record with the last one are looked at.
Sequence nearest_order(const Trace& trace, std::span<const Gather> gathers, std::uint64_t) {
  const auto sets = working_sets(trace, gathers);
  std::vector<std::vector<std::size_t>> users(trace.ids.size());
  for (std::size_t g = 0; g < sets.size(); ++g)
    for (const RecordNumber r : sets[g]) users[r].push_back(g);

  Sequence sequence;
  std::vector<char> done(gathers.size(), 0);
  std::vector<std::uint32_t> common(gathers.size(), 0);  // records, with the last one
  std::size_t first_left = 0;
  while (sequence.size() < gathers.size()) {
    while (done[first_left]) ++first_left;
    std::size_t best = first_left;
    std::vector<std::size_t> touched;
    if (!sequence.empty())
      for (const RecordNumber r : sets[sequence.back()])
        for (const std::size_t g : users[r])
          if (!done[g] && common[g]++ == 0) touched.push_back(g);
    for (const std::size_t g : touched)
      if (common[g] > common[best] || (common[g] == common[best] && g < best)) best = g;
    for (const std::size_t g : touched) common[g] = 0;
    done[best] = 1;
    sequence.push_back(best);
  }
  return sequence;
}

struct NamedOrder {
  const char* name;
  Sequence (*order)(const Trace& trace, std::span<const Gather> gathers, std::uint64_t seed);
};

constexpr NamedOrder kOrders[] = {{"recorded", recorded_order},
                                  {"reverse", reverse_order},
                                  {"model", model_order},
                                  {"random", random_order},
                                  {"nearest", nearest_order}};

Status no_such_order(const std::string& name) {
  std::string known;
  for (const std::string& n : reorder_names()) known += (known.empty() ? "" : ", ") + n;
  return Status(Code::kUsage, "order", name, "there is no such order", "one of: " + known);
}

// Payload bytes of reads and releases, as the dirtying and creating before them makes them.
void follow_sizes(Trace& trace) {
  std::vector<std::uint64_t> payload = trace.sizes;
  for (TraceEvent& event : trace.events) {
    if (event.op == TraceOp::kDirty || event.op == TraceOp::kCreate)
      payload[event.record] = event.bytes;
    if (event.op == TraceOp::kRead || event.op == TraceOp::kRelease)
      event.bytes = payload[event.record];
  }
}

// Gather for gather, `sequence` instead of the one recorded; what stands between them is kept.
void append_reordered(const Trace& trace, std::span<const Gather> gathers, const Sequence& sequence,
                      std::vector<TraceEvent>& events) {
  for (std::size_t i = 0; i < gathers.size(); ++i) {
    if (i > 0) {
      const auto between = events_of(trace, {gathers[i - 1].last, gathers[i].first});
      events.insert(events.end(), between.begin(), between.end());
    }
    const auto gather = events_of(trace, gathers[sequence[i]]);
    events.insert(events.end(), gather.begin(), gather.end());
  }
}

}  // namespace

std::vector<std::string> reorder_names() {
  std::vector<std::string> names;
  for (const NamedOrder& order : kOrders) names.push_back(order.name);
  return names;
}

Result<Trace> reorder(const Trace& trace, const std::string& order, std::uint64_t seed) {
  const auto named = std::ranges::find(kOrders, order, &NamedOrder::name);
  if (named == std::end(kOrders)) return no_such_order(order);
  ATRIUM_RETURN_IF_ERROR(check_trace(trace));
  const auto iterations = gathers_of(trace);
  Trace reordered = trace;
  reordered.events.clear();
  std::size_t copied = 0;  // events of the trace
  for (const auto& gathers : iterations) {
    if (gathers.empty()) continue;
    const auto before = events_of(trace, {copied, gathers.front().first});
    reordered.events.insert(reordered.events.end(), before.begin(), before.end());
    append_reordered(trace, gathers, named->order(trace, gathers, seed), reordered.events);
    copied = gathers.back().last;
  }
  if (copied == 0)
    return Status(Code::kUsage, "trace", "", "it has no gathers to reorder",
                  "record it from a solve");
  const auto rest = events_of(trace, {copied, trace.events.size()});
  reordered.events.insert(reordered.events.end(), rest.begin(), rest.end());
  const Status sound = check_trace(reordered);
  if (!sound.ok())
    return Status(Code::kUsage, "trace", sound.place(),
                  "gathers cannot change places, one needs what another does: " + sound.cause(),
                  "simulate it in the order recorded");
  follow_sizes(reordered);
  return reordered;
}

}  // namespace atrium
