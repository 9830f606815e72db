#include "pagestore/replay.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <vector>

#include "engine/check.h"
#include "pagestore/io_clock.h"

namespace atrium {

namespace {

// What stands in a record after it was dirtied `writes` times: words that differ between records,
// times and places.
void fill_content(std::span<std::byte> bytes, RecordNumber record, std::uint32_t writes) {
  std::uint64_t word = (std::uint64_t{record} << 32 | writes) * 0x9e3779b97f4a7c15u + 1;
  constexpr std::uint64_t kStep = 0xbf58476d1ce4e5b9u;
  std::size_t at = 0;
  for (; at + sizeof word <= bytes.size(); at += sizeof word, word += kStep)
    std::memcpy(bytes.data() + at, &word, sizeof word);
  std::memcpy(bytes.data() + at, &word, bytes.size() - at);
}

// The events at which a record is read to be dirtied before that pin goes: they are edits.
std::vector<bool> reads_that_dirty(const Trace& trace) {
  std::vector<bool> dirties(trace.events.size(), false);
  std::vector<bool> pending(trace.ids.size(), false);
  for (std::size_t i = trace.events.size(); i-- > 0;) {
    const TraceEvent& e = trace.events[i];
    if (e.op == TraceOp::kDirty) pending[e.record] = true;
    if (e.op != TraceOp::kRead || !pending[e.record]) continue;
    dirties[i] = true;
    pending[e.record] = false;
  }
  return dirties;
}

// Memory for an arena that is charged payloads alone: as many of the smallest records as it holds
// take a header and a granule more, and holes an eighth.
std::size_t payload_arena_memory(const Trace& trace, std::uint64_t arena) {
  std::vector<std::uint64_t> sizes(trace.ids.size(), ~std::uint64_t{0});
  for (const TraceEvent& e : trace.events) sizes[e.record] = std::min(sizes[e.record], e.bytes);
  std::ranges::sort(sizes);
  std::uint64_t records = 0, bytes = 0;
  while (records < sizes.size() && bytes + sizes[records] <= arena) bytes += sizes[records++];
  const std::uint64_t memory = arena + records * (sizeof(RecordHeader) + kGranule);
  return memory + memory / 8;
}

class Player {
 public:
  Player(const Trace& trace, const ReplayOptions& options)
      : trace_(trace),
        options_(options),
        held_(trace.ids.size()),
        sizes_(trace.sizes),
        writes_(trace.ids.size(), 0) {}

  Result<Replay> run() {
    ATRIUM_RETURN_IF_ERROR(make_store());
    ATRIUM_RETURN_IF_ERROR(make_records());
    foresee_all();
    const StoreCounters before = store_->counters();
    const std::vector<bool> edits = reads_that_dirty(trace_);
    for (std::size_t i = 0; i < trace_.events.size(); ++i)
      ATRIUM_RETURN_IF_ERROR(play(trace_.events[i], edits[i]));
    ATRIUM_RETURN_IF_ERROR(checkpoint());
    return report(store_->counters() - before);
  }

 private:
  // A record's pins, oldest first; an edit is the last of them.
  struct Held {
    std::vector<ClusterPin> pins;
    std::optional<ClusterEdit> edit;
  };

  RecordId id(RecordNumber record) const { return record_id(RecordKind::kOther, record); }

  Status make_store() {
    StoreOptions store;
    store.arena_bytes = options_.arena;
    store.policy = options_.policy;
    store.io = options_.io;
    if (!trace_.pins) store.payload_arena_memory = payload_arena_memory(trace_, options_.arena);
    auto made = ClusterStore::create(options_.directory, store);
    if (!made.ok()) return made.status();
    store_ = std::move(made).value();
    return {};
  }

  // All records by their numbers, so that the store's policy calls them as the simulated one does.
  // Those that come into being later only leave their number.
  Status make_records() {
    if (!trace_.pins)
      for (std::size_t i = trace_.events.size(); i-- > 0;)
        sizes_[trace_.events[i].record] = trace_.events[i].bytes;  // the first request's
    std::vector<bool> created(trace_.ids.size(), false);
    for (const TraceEvent& e : trace_.events)
      if (e.op == TraceOp::kCreate) created[e.record] = true;
    for (RecordNumber r = 0; r < trace_.ids.size(); ++r) {
      ATRIUM_RETURN_IF_ERROR(write_past(r, sizes_[r]));
      if (created[r]) store_->drop_streamed(id(r));
    }
    return store_->checkpoint({});
  }

  Status write_past(RecordNumber r, std::uint64_t size) {
    scratch_.resize(size);
    fill_content(scratch_, r, writes_[r]);
    sizes_[r] = size;
    return store_->stream_out(id(r), scratch_);
  }

  void foresee_all() {
    std::vector<RecordId> requests;
    for (const TraceEvent& e : trace_.events)
      if (is_request(e.op)) requests.push_back(id(e.record));
    const IoClock clock(seconds_);
    store_->foresee(requests);
  }

  Status play(const TraceEvent& e, bool edits) {
    switch (e.op) {
      case TraceOp::kRead:
        return read(e.record, edits);
      case TraceOp::kDirty:
        return dirty(e.record, e.bytes);
      case TraceOp::kRelease:
        return release(e.record);
      case TraceOp::kCreate:
        return create(e.record, e.bytes);
      case TraceOp::kGet:
      case TraceOp::kPut:
        return get(e);
      case TraceOp::kCheckpoint:
        return checkpoint();
      case TraceOp::kGather:
      case TraceOp::kIteration:
        return {};
    }
    return {};
  }

  Status read(RecordNumber r, bool edits) {
    before_ = store_->counters().reads;
    Held& held = held_[r];
    if (edits) {
      auto edit = [&] { const IoClock clock(seconds_); return store_->edit(id(r)); }();
      if (!edit.ok()) return edit.status();
      held.edit = std::move(edit).value();
      return check(r, held.edit->bytes());
    }
    auto pin = [&] { const IoClock clock(seconds_); return store_->read(id(r)); }();
    if (!pin.ok()) return pin.status();
    held.pins.push_back(std::move(pin).value());
    return check(r, held.pins.back().bytes());
  }

  Status dirty(RecordNumber r, std::uint64_t bytes) {
    Held& held = held_[r];
    if (!held.edit || (!held.pins.empty() && bytes != sizes_[r]))
      return Status(Code::kUsage, "trace", "record " + std::to_string(trace_.ids[r]),
                    "it changes its size while it is pinned twice", "replay another trace");
    if (bytes != sizes_[r]) {
      const IoClock clock(seconds_);
      ATRIUM_RETURN_IF_ERROR(held.edit->resize(bytes));
    }
    sizes_[r] = bytes;
    fill_content(held.edit->bytes(), r, ++writes_[r]);
    return {};
  }

  Status release(RecordNumber r) {
    Held& held = held_[r];
    const IoClock clock(seconds_);
    if (held.edit)
      held.edit.reset();
    else
      held.pins.pop_back();
    return {};
  }

  Status create(RecordNumber r, std::uint64_t bytes) {
    scratch_.resize(bytes);
    fill_content(scratch_, r, writes_[r]);
    sizes_[r] = bytes;
    const IoClock clock(seconds_);
    return store_->create_record(id(r), scratch_);
  }

  // Of a trace without pins: what is brought in has the size that the request says.
  Status get(const TraceEvent& e) {
    if (e.bytes != sizes_[e.record] && !store_->in_arena(id(e.record)))
      ATRIUM_RETURN_IF_ERROR(write_past(e.record, e.bytes));
    before_ = store_->counters().reads;
    auto pin = [&] { const IoClock clock(seconds_); return store_->read_or_pass(id(e.record)); }();
    if (!pin.ok()) return pin.status();
    if (!pin->has_value()) return {};
    ATRIUM_RETURN_IF_ERROR(check(e.record, (*pin)->bytes()));
    if (e.op == TraceOp::kGet) return {};
    auto edit = ClusterEdit::of(std::move(**pin));
    if (!edit.ok()) return edit.status();
    fill_content(edit->bytes(), e.record, ++writes_[e.record]);
    return {};
  }

  // What has just been brought in holds what was last written.
  Status check(RecordNumber r, std::span<const std::byte> bytes) {
    if (store_->counters().reads == before_) return {};
    scratch_.resize(sizes_[r]);
    fill_content(scratch_, r, writes_[r]);
    if (std::ranges::equal(bytes, scratch_)) return {};
    return Status(Code::kStore, options_.directory, "record " + std::to_string(trace_.ids[r]),
                  "it came back other than it was written",
                  "check the disk, and report this: the store did not notice");
  }

  Status checkpoint() {
    const StoreCounters& now = store_->counters();
    const std::uint64_t writes = now.checkpoint_writes, bytes = now.checkpoint_bytes;
    {
      const IoClock clock(seconds_);
      ATRIUM_RETURN_IF_ERROR(store_->checkpoint({}));
    }
    // Those without a request behind them are one final flush.
    if (now.requests != flushed_at_) flushed_writes_ = flushed_bytes_ = 0;
    flushed_at_ = now.requests;
    flushed_writes_ += now.checkpoint_writes - writes;
    flushed_bytes_ += now.checkpoint_bytes - bytes;
    return {};
  }

  Replay report(const StoreCounters& c) const {
    Replay replay;
    Simulation& s = replay.counts;
    s.policy = options_.policy;
    s.arena = options_.arena;
    s.requests = c.requests;
    s.hits = c.hits();
    s.misses = c.reads;
    s.miss_bytes = c.bytes_read;
    s.evictions = c.evictions;
    s.writebacks = c.writes - c.checkpoint_writes;
    s.writeback_bytes = c.bytes_written - c.checkpoint_bytes;
    s.final_flush = flushed_writes_;
    s.final_flush_bytes = flushed_bytes_;
    s.checkpoint_writes = c.checkpoint_writes - flushed_writes_;
    s.checkpoint_bytes = c.checkpoint_bytes - flushed_bytes_;
    s.min_feasible_arena = smallest_feasible_arena(trace_, false);
    s.seconds = seconds_;
    replay.fragmentation_evictions = c.fragmentation_evictions;
    replay.io_seconds = c.io_seconds;
    return replay;
  }

  const Trace& trace_;
  const ReplayOptions& options_;
  std::unique_ptr<ClusterStore> store_;
  std::vector<Held> held_;  // goes before the store
  std::vector<std::uint64_t> sizes_;
  std::vector<std::uint32_t> writes_;
  std::vector<std::byte> scratch_;
  std::uint64_t before_ = 0;  // reads, before the request that is under way
  std::uint64_t flushed_at_ = ~std::uint64_t{0}, flushed_writes_ = 0, flushed_bytes_ = 0;
  double seconds_ = 0;
};

}  // namespace

Result<Replay> replay(const Trace& trace, const ReplayOptions& options) {
  ATRIUM_RETURN_IF_ERROR(check_trace(trace));
  const std::uint64_t smallest = smallest_feasible_arena(trace, false);
  if (trace.pins && options.arena < smallest)
    return Status(Code::kUsage, "--arena", "", std::to_string(options.arena) + " bytes are less than what is pinned at once",
                  "the smallest that will do is " + std::to_string(smallest) + " bytes");
  return Player(trace, options).run();
}

}  // namespace atrium
