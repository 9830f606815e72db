#include "pagestore/simulate.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <vector>

#include "engine/check.h"
#include "pagestore/policy.h"

namespace atrium {

namespace {

// What the caller of a policy knows of the future, and when it tells: each next request once, as
// soon as it is at most `reach` requests after the last one begun.
class Foresight {
 public:
  Foresight(const Trace& trace, std::uint64_t reach) {
    if (reach == 0) return;
    next_ = next_requests(trace);
    reach_ = std::min<std::uint64_t>(reach, next_.size());
    records_.reserve(next_.size());
    for (const TraceEvent& event : trace.events)
      if (is_request(event.op)) records_.push_back(event.record);
    next_of_record_.resize(trace.ids.size(), kNeverAgain);
    for (std::uint64_t request = next_.size(); request-- > 0;)
      next_of_record_[records_[request]] = request;
  }

  // Goes on to a request. Returns the record whose next request comes within reach by that, if
  // there is one; it is not the record requested now.
  std::optional<RecordNumber> begin(std::uint64_t request) {
    if (reach_ == 0) return std::nullopt;
    begun_ = request + 1;
    next_of_record_[records_[request]] = next_[request];
    const std::uint64_t last_seen = request + reach_;
    if (last_seen >= next_.size()) return std::nullopt;
    const RecordNumber record = records_[last_seen];
    const bool news = next_of_record_[record] == last_seen && record != records_[request];
    return news ? std::optional(record) : std::nullopt;
  }

  // The record's next request; none if out of reach, or never.
  std::optional<std::uint64_t> next(RecordNumber record) const {
    if (reach_ == 0 || next_of_record_[record] >= begun_ + reach_) return std::nullopt;
    return next_of_record_[record];
  }

 private:
  std::uint64_t reach_ = 0;                    // requests ahead
  std::uint64_t begun_ = 0;                    // requests
  std::vector<std::uint64_t> next_;            // by request
  std::vector<RecordNumber> records_;          // by request
  std::vector<std::uint64_t> next_of_record_;  // from here on
};

// One trace on its way through one arena.
//
// 1. occupied_ is the sum of `charge` over the records in the arena; at most arena_ between events.
// 2. The policy has been told of every record in the arena, and of no other, that it is there.
class Run {
 public:
  Run(const Trace& trace, const PolicyChoice& choice, std::uint64_t arena, bool unit_size)
      : trace_(trace),
        unit_size_(unit_size),
        arena_(arena),
        policy_(make_policy(choice, arena)),
        foresight_(trace, choice.foresight),
        records_(trace.ids.size()) {
    for (std::size_t r = 0; r < records_.size(); ++r) records_[r].payload = trace.sizes[r];
  }

  void count_into(Simulation& counts, CountedPart part) {
    Simulation not_counted;
    counts_ = part.here ? &counts : &not_counted;
    std::size_t left = request_count(trace_);
    for (const TraceEvent& event : trace_.events) {
      part.pass(event);
      counts_ = part.here ? &counts : &not_counted;
      left -= is_request(event.op) ? 1 : 0;
      if (event.op == TraceOp::kCheckpoint)
        checkpoint(left > 0);
      else
        play(event);
    }
    if (part.here) checkpoint(false);
  }

 private:
  struct Held {
    std::uint64_t payload = 0;  // bytes; in traces without pins: of what is in the arena
    std::uint64_t charge = 0;   // of the arena
    std::uint32_t pins = 0;
    bool in_arena = false, dirty = false;
  };

  void play(const TraceEvent& event) {
    switch (event.op) {
      case TraceOp::kRead:
      case TraceOp::kGet:
      case TraceOp::kPut:
        return request(event);
      case TraceOp::kDirty:
        return dirty(event);
      case TraceOp::kRelease:
        return release(event.record);
      case TraceOp::kCreate:
        return create(event);
      case TraceOp::kGather:
      case TraceOp::kIteration:
      case TraceOp::kCheckpoint:
        return;
    }
  }

  void request(const TraceEvent& event) {
    const RecordNumber r = event.record;
    Held& held = records_[r];
    const auto in_reach = foresight_.begin(now_);
    if (in_reach && records_[*in_reach].in_arena) foresee(*in_reach);
    if (held.in_arena) {
      ++counts_->hits;
      policy_->on_hit(r);
    } else {
      const std::uint64_t payload = trace_.pins ? held.payload : event.bytes;
      ++counts_->misses;
      counts_->miss_bytes += payload;
      bring_in(r, payload);
    }
    ++counts_->requests;
    if (held.in_arena) foresee(r);
    ++now_;
    if (trace_.pins) {
      ++held.pins;
    } else if (held.in_arena) {
      held.dirty = held.dirty || event.op == TraceOp::kPut;
      policy_->on_release(r);
    }
  }

  void bring_in(RecordNumber r, std::uint64_t payload) {
    const std::uint64_t charge = arena_charge(trace_, payload, unit_size_);
    policy_->on_miss(r, charge);
    if (!trace_.pins && (charge > arena_ || !policy_->admits(r, charge))) return;
    enter(r, payload, charge);
  }

  void enter(RecordNumber r, std::uint64_t payload, std::uint64_t charge) {
    make_room(charge);
    Held& held = records_[r];
    held.payload = payload;
    held.charge = charge;
    held.in_arena = true;
    occupied_ += charge;
    policy_->on_insert(r, charge);
  }

  void dirty(const TraceEvent& event) {
    Held& held = records_[event.record];
    const std::uint64_t charge = arena_charge(trace_, event.bytes, unit_size_);
    occupied_ -= held.charge;
    make_room(charge);
    occupied_ += charge;
    held.payload = event.bytes;
    held.charge = charge;
    held.dirty = true;
    policy_->on_resize(event.record, charge);
  }

  void release(RecordNumber r) {
    if (--records_[r].pins == 0) policy_->on_release(r);
  }

  void create(const TraceEvent& event) {
    const RecordNumber r = event.record;
    enter(r, event.bytes, arena_charge(trace_, event.bytes, unit_size_));
    records_[r].dirty = true;
    foresee(r);
    policy_->on_release(r);
  }

  void make_room(std::uint64_t charge) {
    while (occupied_ + charge > arena_) {
      const auto victim = policy_->victim(now_);
      ATRIUM_CHECK(victim);  // or what is pinned would be more than the smallest feasible arena
      evict(*victim);
    }
  }

  void evict(RecordNumber r) {
    Held& held = records_[r];
    ATRIUM_CHECK(held.in_arena && held.pins == 0);
    if (held.dirty) {
      ++counts_->writebacks;
      counts_->writeback_bytes += held.payload;
    }
    held.dirty = held.in_arena = false;
    occupied_ -= held.charge;
    ++counts_->evictions;
    policy_->on_evict(r);
  }

  // Every dirty record is written; the last time belongs to the final flush.
  void checkpoint(bool requests_follow) {
    std::uint64_t writes = 0, bytes = 0;
    for (Held& held : records_) {
      if (!held.dirty) continue;
      held.dirty = false;
      ++writes;
      bytes += held.payload;
    }
    (requests_follow ? counts_->checkpoint_writes : counts_->final_flush) += writes;
    (requests_follow ? counts_->checkpoint_bytes : counts_->final_flush_bytes) += bytes;
  }

  void foresee(RecordNumber r) {
    if (const auto when = foresight_.next(r)) policy_->on_foreseen(r, *when);
  }

  const Trace& trace_;
  const bool unit_size_;
  const std::uint64_t arena_;
  const std::unique_ptr<Policy> policy_;
  Foresight foresight_;
  std::vector<Held> records_;
  std::uint64_t occupied_ = 0;
  std::uint64_t now_ = 0;  // number of the request that is next or under way
  Simulation* counts_ = nullptr;
};

double modelled_seconds(const Simulation& counts, const DiskModel& disk) {
  const std::uint64_t operations =
      counts.misses + counts.writebacks + counts.checkpoint_writes + counts.final_flush;
  const std::uint64_t bytes = counts.miss_bytes + counts.writeback_bytes + counts.checkpoint_bytes +
                              counts.final_flush_bytes;
  return static_cast<double>(operations) * disk.seconds_per_operation +
         static_cast<double>(bytes) / disk.bandwidth;
}

}  // namespace

Result<Simulation> simulate(const Trace& trace, const std::string& policy, std::uint64_t arena,
                            bool unit_size, const DiskModel& disk, std::uint64_t iteration) {
  const auto choice = parse_policy(policy);
  if (!choice.ok()) return choice.status();
  ATRIUM_RETURN_IF_ERROR(check_trace(trace));
  Simulation counts;
  counts.policy = policy;
  counts.arena = arena;
  counts.min_feasible_arena = smallest_feasible_arena(trace, unit_size);
  counts.feasible = !trace.pins || arena >= counts.min_feasible_arena;
  if (!counts.feasible) return counts;
  Run(trace, *choice, arena, unit_size).count_into(counts, CountedPart(iteration));
  counts.seconds = modelled_seconds(counts, disk);
  return counts;
}

}  // namespace atrium
