#include "pagestore/curve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "engine/check.h"
#include "pagestore/recency.h"
#include "pagestore/record.h"
#include "pagestore/simulate.h"

namespace atrium {
namespace {

// What changes in the counts of all arenas of so many bytes and more.
enum class ChangeKind : std::uint8_t { kHit, kDirtyVictim, kCleanVictim, kFlush };

struct Change {
  std::uint64_t arena;
  std::uint64_t bytes;
  ChangeKind kind;
};

void apply(const Change& change, CurvePoint& point) {
  switch (change.kind) {
    case ChangeKind::kHit:
      --point.misses;
      point.miss_bytes -= change.bytes;
      break;
    case ChangeKind::kDirtyVictim:
      ++point.writebacks;
      point.writeback_bytes += change.bytes;
      break;
    case ChangeKind::kCleanVictim:
      --point.writebacks;
      point.writeback_bytes -= change.bytes;
      break;
    case ChangeKind::kFlush:
      ++point.final_flush;
      break;
  }
}

// By arena: least significant digit first; a digit that all share is passed over.
void sort_changes(std::vector<Change>& changes) {
  constexpr int kDigitBits = 11;
  constexpr std::size_t kDigits = std::size_t{1} << kDigitBits;
  std::uint64_t differing = 0;
  for (const Change& change : changes) differing |= change.arena ^ changes.front().arena;
  std::vector<Change> sorted(changes.size());
  for (int shift = 0; shift < 64 && differing >> shift != 0; shift += kDigitBits) {
    const auto digit = [shift](const Change& change) { return (change.arena >> shift) % kDigits; };
    if ((differing >> shift) % kDigits == 0) continue;
    std::array<std::size_t, kDigits + 1> starts{};
    for (const Change& change : changes) ++starts[digit(change) + 1];
    for (std::size_t i = 0; i < kDigits; ++i) starts[i + 1] += starts[i];
    for (const Change& change : changes) sorted[starts[digit(change)]++] = change;
    changes.swap(sorted);
  }
}

// One pass of a trace through the LRU stacks of all arenas at once.
//
// A record is pinned, and then in every arena and above all that is not; or in `recency_`; or was
// not seen yet. Its distance is that of curve.h; its dirty level L, the arena from which on it is
// dirty while it is in.
class LruPass {
 public:
  LruPass(const Trace& trace, bool unit_size)
      : trace_(trace),
        unit_size_(unit_size),
        smallest_(smallest_feasible_arena(trace, unit_size)),
        records_(trace.ids.size()),
        recency_(trace.ids.size()) {
    for (std::size_t i = 0; i < records_.size(); ++i) records_[i].payload = trace.sizes[i];
    changes_.reserve(trace.events.size());  // what is not used is never touched
  }

  MissCurve run();

 private:
  static constexpr std::uint64_t kClean = std::numeric_limits<std::uint64_t>::max();
  struct Record {
    std::uint64_t payload = 0;
    std::uint64_t dirty_level = kClean;
    std::uint32_t pins = 0;
  };

  std::uint64_t charge(const Record& record) const {
    return arena_charge(trace_, record.payload, unit_size_);
  }
  void get(RecordNumber number, std::uint64_t payload);
  void pin(RecordNumber number);
  void resize(RecordNumber number, std::uint64_t payload);
  void release(RecordNumber number);
  void create(RecordNumber number, std::uint64_t payload);
  void dirty(RecordNumber number);
  void checkpoint(bool last);
  void request(RecordNumber number, std::uint64_t payload);
  void count_evictions(const Record& record, std::uint64_t distance);
  void change(ChangeKind kind, std::uint64_t arena, std::uint64_t bytes);

  const Trace& trace_;
  const bool unit_size_;
  const std::uint64_t smallest_;  // bytes
  std::vector<Record> records_;
  Recency recency_;
  std::uint64_t pinned_ = 0;         // bytes
  std::vector<RecordNumber> dirty_;  // those with a dirty level
  CurvePoint first_;                 // the counts at `smallest_`
  std::vector<Change> changes_;      // beyond it
  std::uint64_t requests_ = 0;
};

std::vector<CurvePoint> points_of(const CurvePoint& first, std::vector<Change> changes) {
  sort_changes(changes);
  std::vector<CurvePoint> points;
  points.reserve(changes.size() + 1);
  points.push_back(first);
  for (const Change& change : changes) {
    if (change.arena != points.back().arena) {
      points.push_back(points.back());
      points.back().arena = change.arena;
    }
    apply(change, points.back());
  }
  return points;
}

// A checkpoint after the last request is the final flush.
std::size_t last_request(const Trace& trace) {
  std::size_t last = trace.events.size();
  while (last > 0 && !is_request(trace.events[last - 1].op)) --last;
  return last;
}

MissCurve LruPass::run() {
  const std::size_t requests_end = last_request(trace_);
  for (std::size_t i = 0; i < trace_.events.size(); ++i) {
    const TraceEvent& event = trace_.events[i];
    switch (event.op) {
      case TraceOp::kGet:
        get(event.record, event.bytes);
        break;
      case TraceOp::kPut:
        get(event.record, event.bytes);
        dirty(event.record);
        break;
      case TraceOp::kRead:
        pin(event.record);
        break;
      case TraceOp::kDirty:
        resize(event.record, event.bytes);
        dirty(event.record);
        break;
      case TraceOp::kRelease:
        release(event.record);
        break;
      case TraceOp::kCreate:
        create(event.record, event.bytes);
        dirty(event.record);
        break;
      case TraceOp::kCheckpoint:
        checkpoint(i >= requests_end);
        break;
      case TraceOp::kGather:
      case TraceOp::kIteration:
        break;
    }
  }
  checkpoint(true);
  first_.arena = smallest_;
  return {"lru", requests_, smallest_, 1, points_of(first_, std::move(changes_))};
}

void LruPass::get(RecordNumber number, std::uint64_t payload) {
  request(number, payload);
  records_[number].payload = payload;
  recency_.push(number, charge(records_[number]));
}

void LruPass::pin(RecordNumber number) {
  Record& record = records_[number];
  if (record.pins++ > 0) {
    ++requests_;  // a hit in every arena
    return;
  }
  request(number, record.payload);
  pinned_ += charge(record);
}

void LruPass::resize(RecordNumber number, std::uint64_t payload) {
  Record& record = records_[number];
  ATRIUM_CHECK(record.pins > 0);
  pinned_ -= charge(record);
  record.payload = payload;
  pinned_ += charge(record);
}

void LruPass::release(RecordNumber number) {
  Record& record = records_[number];
  ATRIUM_CHECK(record.pins > 0);
  if (--record.pins > 0) return;
  pinned_ -= charge(record);
  recency_.push(number, charge(record));
}

void LruPass::create(RecordNumber number, std::uint64_t payload) {
  records_[number].payload = payload;
  recency_.push(number, charge(records_[number]));
}

// In every arena, as it was just requested.
void LruPass::dirty(RecordNumber number) {
  if (records_[number].dirty_level == kClean) dirty_.push_back(number);
  records_[number].dirty_level = 0;
}

// last: counts as the final flush.
void LruPass::checkpoint(bool last) {
  for (const RecordNumber number : dirty_) {
    Record& record = records_[number];
    const std::uint64_t distance = record.pins > 0 ? 0 : pinned_ + recency_.from_top(number);
    count_evictions(record, distance);
    if (last) change(ChangeKind::kFlush, std::max(record.dirty_level, distance), record.payload);
    record.dirty_level = kClean;
  }
  dirty_.clear();
}

// A request for a record that is not pinned. It is in no stack then: for its caller to put back.
void LruPass::request(RecordNumber number, std::uint64_t payload) {
  ++requests_;
  ++first_.misses;
  first_.miss_bytes += payload;
  if (!recency_.holds(number)) return;
  Record& record = records_[number];
  const std::uint64_t distance = pinned_ + recency_.from_top(number);
  recency_.remove(number);
  change(ChangeKind::kHit, distance, payload);
  count_evictions(record, distance);
  if (record.dirty_level != kClean) record.dirty_level = std::max(record.dirty_level, distance);
}

// Since its last release a record has left all arenas below `distance`.
void LruPass::count_evictions(const Record& record, std::uint64_t distance) {
  if (record.dirty_level >= distance) return;
  change(ChangeKind::kDirtyVictim, record.dirty_level, record.payload);
  change(ChangeKind::kCleanVictim, distance, record.payload);
}

void LruPass::change(ChangeKind kind, std::uint64_t arena, std::uint64_t bytes) {
  const Change change{arena, bytes, kind};
  if (arena <= smallest_) {
    apply(change, first_);
  } else {
    changes_.push_back(change);
  }
}

}  // namespace

const CurvePoint& MissCurve::at(std::uint64_t arena) const {
  ATRIUM_CHECK(arena >= smallest_arena);
  const auto after = std::upper_bound(
      points.begin(), points.end(), arena,
      [](std::uint64_t bytes, const CurvePoint& point) { return bytes < point.arena; });
  return *(after - 1);
}

MissCurve lru_curve(const Trace& trace, bool unit_size) { return LruPass(trace, unit_size).run(); }

}  // namespace atrium
