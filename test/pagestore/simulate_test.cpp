#include "pagestore/simulate.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>

#include "pagestore/record.h"
#include "test/pagestore/random_trace.h"

namespace atrium {
namespace {

Trace requests_of(const std::string& letters) {
  Trace trace;
  for (RecordNumber r = 0; r < 26; ++r) {
    trace.ids.push_back(r);
    trace.sizes.push_back(0);
  }
  for (const char c : letters)
    trace.events.push_back({TraceOp::kGet, static_cast<RecordNumber>(c - 'a'), 1});
  return trace;
}

// [Belady, Nelson, Shedler, "An anomaly in space-time characteristics of certain programs running
// in a paging machine", 1969]: FIFO has more faults in four frames than in three.
TEST(Simulate, TheClassicReferenceString) {
  const Trace trace = requests_of("abcdabeabcde");
  const auto misses = [&](const char* policy, std::uint64_t arena) {
    return simulate(trace, policy, arena)->misses;
  };
  EXPECT_EQ(misses("fifo", 3), 9u);
  EXPECT_EQ(misses("fifo", 4), 10u);
  EXPECT_EQ(misses("lru", 3), 10u);
  EXPECT_EQ(misses("lru", 4), 8u);
  EXPECT_EQ(misses("belady", 3), 7u);
  EXPECT_EQ(misses("belady", 4), 6u);
}

// A trace of ours with three records of two, one and one granules.
struct Pinned : Trace {
  Pinned() {
    pins = true;
    ids = {10, 11, 12};
    sizes = {5000, 100, 200};
  }
  Pinned& add(TraceOp op, RecordNumber record = 0, std::uint64_t bytes = 0) {
    events.push_back({op, record, bytes});
    return *this;
  }
  Pinned& touch(RecordNumber record) {
    return add(TraceOp::kRead, record).add(TraceOp::kRelease, record);
  }
};

TEST(Simulate, ADirtyVictimIsWrittenBackACleanOneIsNot) {
  Pinned trace;
  trace.add(TraceOp::kRead, 1).add(TraceOp::kDirty, 1, 150).add(TraceOp::kRelease, 1);
  trace.touch(2).touch(0).touch(2);  // room for 0: both leave; for 2: 0 leaves
  const Simulation counts = *simulate(trace, "lru", 2 * kGranule);
  EXPECT_EQ(counts.requests, 4u);
  EXPECT_EQ(counts.misses, 4u);
  EXPECT_EQ(counts.miss_bytes, 100u + 200 + 5000 + 200);
  EXPECT_EQ(counts.evictions, 3u);
  EXPECT_EQ(counts.writebacks, 1u);
  EXPECT_EQ(counts.writeback_bytes, 150u);
  EXPECT_EQ(counts.final_flush, 0u);
  // Five operations of 0.1 ms, 5650 bytes at 1 GB/s.
  EXPECT_DOUBLE_EQ(counts.seconds, 5 * 100e-6 + 5650 / 1e9);
}

TEST(Simulate, APinnedRecordIsPassedOver) {
  Pinned trace;
  trace.add(TraceOp::kRead, 1).touch(2).touch(0).touch(1).add(TraceOp::kRelease, 1);
  const Simulation counts = *simulate(trace, "lru", 3 * kGranule);
  EXPECT_EQ(counts.evictions, 1u);  // 2 for 0, though 1 was requested before it
  EXPECT_EQ(counts.hits, 1u);       // 1
}

TEST(Simulate, ARecordThatGrowsPushesOthersOutAndOneThatShrinksMakesRoom) {
  Pinned trace;
  trace.touch(2).add(TraceOp::kRead, 1).add(TraceOp::kDirty, 1, 2 * kGranule);
  EXPECT_EQ(simulate(trace, "lru", 3 * kGranule)->evictions, 1u);  // three granules: 2 leaves
  trace.add(TraceOp::kDirty, 1, 100).add(TraceOp::kRelease, 1);
  trace.touch(2).touch(2).touch(0);  // 1 has one granule again, so 2 fits beside it
  const Simulation counts = *simulate(trace, "lru", 3 * kGranule);
  EXPECT_EQ(counts.hits, 1u);
  EXPECT_EQ(counts.evictions, 2u);  // 2, and 1 for 0
}

TEST(Simulate, ACreatedRecordComesInDirtyAndIsNoRequest) {
  Pinned trace;
  trace.sizes[2] = 0;
  trace.touch(1).add(TraceOp::kCreate, 2, 300).touch(2);
  const Simulation counts = *simulate(trace, "lru", kGranule);
  EXPECT_EQ(counts.requests, 2u);
  EXPECT_EQ(counts.misses, 1u);
  EXPECT_EQ(counts.hits, 1u);
  EXPECT_EQ(counts.evictions, 1u);
  EXPECT_EQ(counts.final_flush, 1u);
  EXPECT_EQ(counts.final_flush_bytes, 300u);
}

TEST(Simulate, ACheckpointWritesAndLeavesCleanTheLastOneIsTheFinalFlush) {
  Pinned trace;
  const auto dirty = [&](RecordNumber r) {
    trace.add(TraceOp::kRead, r).add(TraceOp::kDirty, r, 700 + r).add(TraceOp::kRelease, r);
  };
  dirty(1);
  dirty(2);
  trace.add(TraceOp::kCheckpoint).add(TraceOp::kCheckpoint).touch(1).touch(0);  // 1, 2 leave clean
  dirty(1);
  trace.add(TraceOp::kCheckpoint);
  const Simulation counts = *simulate(trace, "lru", 3 * kGranule);
  EXPECT_EQ(counts.checkpoint_writes, 2u);
  EXPECT_EQ(counts.checkpoint_bytes, 701u + 702);
  EXPECT_EQ(counts.writebacks, 0u);
  EXPECT_EQ(counts.final_flush, 1u);
  EXPECT_EQ(counts.final_flush_bytes, 701u);
}

TEST(Simulate, AnArenaBelowWhatIsPinnedIsInfeasible) {
  Pinned trace;
  trace.add(TraceOp::kRead, 0).touch(1);
  EXPECT_TRUE(simulate(trace, "lru", 3 * kGranule)->feasible);
  const Simulation counts = *simulate(trace, "lru", 3 * kGranule - 1);
  EXPECT_FALSE(counts.feasible);
  EXPECT_EQ(counts.min_feasible_arena, 3 * kGranule);
  EXPECT_EQ(counts.requests + counts.misses + counts.evictions, 0u);
}

TEST(Simulate, WhatIsLargerThanTheArenaIsAMissThatChangesNothing) {
  Trace trace = requests_of("abaab");
  trace.events[1].bytes = 11;  // b, at first
  const Simulation counts = *simulate(trace, "lru", 10);
  EXPECT_EQ(counts.misses, 3u);
  EXPECT_EQ(counts.miss_bytes, 1u + 11 + 1);
  EXPECT_EQ(counts.evictions, 0u);
}

TEST(Simulate, AHitLeavesTheSizeAsItIs) {
  Trace trace = requests_of("aab");
  trace.events[1].bytes = 10;  // it would leave no room for b
  EXPECT_EQ(simulate(trace, "lru", 10)->evictions, 0u);
}

TEST(Simulate, NoSuchPolicyAndAnUnsoundTraceAreRefused) {
  EXPECT_EQ(simulate(requests_of("a"), "mru", 10).status().code(), Code::kUsage);
  Pinned trace;
  trace.add(TraceOp::kRelease, 1);
  EXPECT_EQ(simulate(trace, "lru", 10).status().code(), Code::kUsage);
}

// The second method: the rules word by word, over plain lists, looking ahead by reading on.
class SlowArena {
 public:
  enum class Rule { kLru, kFifo, kBelady };

  // reach: requests ahead that Belady sees.
  SlowArena(const Trace& trace, Rule rule, std::uint64_t reach, std::uint64_t arena)
      : trace_(trace), rule_(rule), reach_(reach), arena_(arena) {}

  Simulation run() {
    sizes_ = trace_.sizes;
    std::size_t last_request = 0;
    for (std::size_t i = 0; i < trace_.events.size(); ++i)
      if (is_request(trace_.events[i].op)) last_request = i;
    for (at_ = 0; at_ < trace_.events.size(); ++at_) {
      const TraceEvent& event = trace_.events[at_];
      ++clock_;
      switch (event.op) {
        case TraceOp::kRead:
          read(event.record, sizes_[event.record]);
          break;
        case TraceOp::kDirty:
          make_room(charge(event.bytes) - in_[event.record].charge);
          in_[event.record].charge = charge(event.bytes);
          sizes_[event.record] = event.bytes;
          in_[event.record].dirty = true;
          break;
        case TraceOp::kRelease:
          release(event.record);
          break;
        case TraceOp::kCreate:
          sizes_[event.record] = event.bytes;
          make_room(charge(event.bytes));
          in_[event.record] = {charge(event.bytes), clock_, clock_, 0, true};
          break;
        case TraceOp::kGet:
        case TraceOp::kPut:
          if (!in_.contains(event.record) && charge(event.bytes) > arena_) {
            ++counts_.requests;
            ++counts_.misses;
            counts_.miss_bytes += event.bytes;
            break;
          }
          if (!in_.contains(event.record)) sizes_[event.record] = event.bytes;
          read(event.record, event.bytes);
          in_[event.record].dirty |= event.op == TraceOp::kPut;
          release(event.record);
          break;
        case TraceOp::kCheckpoint:
          flush(at_ > last_request);
          break;
        default:
          break;
      }
    }
    flush(true);
    return counts_;
  }

 private:
  struct Held {
    std::int64_t charge = 0;
    std::uint64_t entered = 0, released = 0;
    int pins = 0;
    bool dirty = false;
  };

  std::int64_t charge(std::uint64_t bytes) const {
    if (!trace_.pins) return static_cast<std::int64_t>(bytes);
    return static_cast<std::int64_t>((bytes + 64 + 4095) / 4096 * 4096);
  }
  void read(RecordNumber r, std::uint64_t bytes) {
    ++counts_.requests;
    if (in_.contains(r)) {
      ++counts_.hits;
    } else {
      ++counts_.misses;
      counts_.miss_bytes += bytes;
      make_room(charge(bytes));
      in_[r] = {charge(bytes), clock_, 0, 0, false};
    }
    ++in_[r].pins;
  }
  void release(RecordNumber r) {
    if (--in_[r].pins == 0) in_[r].released = clock_;
  }
  void make_room(std::int64_t bytes) {
    for (;;) {
      std::int64_t used = bytes;
      for (const auto& [r, held] : in_) used += held.charge;
      if (used <= arena_) return;
      evict();
    }
  }
  void evict() {
    std::optional<RecordNumber> worst;
    for (const auto& [r, held] : in_)
      if (held.pins == 0 && (!worst || goes_before(r, *worst))) worst = r;
    ++counts_.evictions;
    counts_.writebacks += in_.at(*worst).dirty ? 1 : 0;
    counts_.writeback_bytes += in_.at(*worst).dirty ? sizes_[*worst] : 0;
    in_.erase(*worst);
  }
  bool goes_before(RecordNumber a, RecordNumber b) const {
    const Held &x = in_.at(a), &y = in_.at(b);
    if (rule_ == Rule::kFifo) return x.entered < y.entered;
    if (rule_ == Rule::kLru) return x.released < y.released;
    const auto next_a = distance(a), next_b = distance(b);
    if (!next_a && !next_b) return x.released < y.released;
    if (!next_a || !next_b) return !next_a;
    return *next_a > *next_b;
  }
  // Requests to the record's next one.
  std::optional<std::uint64_t> distance(RecordNumber r) const {
    const bool request = is_request(trace_.events[at_].op);
    std::uint64_t ahead = 0;  // requests passed
    for (std::size_t i = request ? at_ + 1 : at_; i < trace_.events.size(); ++i) {
      if (!is_request(trace_.events[i].op)) continue;
      ++ahead;
      if (ahead > reach_) return std::nullopt;
      if (trace_.events[i].record == r) return ahead;
    }
    return std::nullopt;
  }
  void flush(bool last) {
    for (auto& [r, held] : in_) {
      if (!held.dirty) continue;
      held.dirty = false;
      (last ? counts_.final_flush : counts_.checkpoint_writes) += 1;
      (last ? counts_.final_flush_bytes : counts_.checkpoint_bytes) += sizes_[r];
    }
  }

  const Trace& trace_;
  Rule rule_;
  std::uint64_t reach_;
  std::int64_t arena_;
  std::vector<std::uint64_t> sizes_;
  std::map<RecordNumber, Held> in_;
  std::size_t at_ = 0;
  std::uint64_t clock_ = 0;
  Simulation counts_;
};

void expect_same(const Simulation& a, const Simulation& b) {
  EXPECT_EQ(a.requests, b.requests);
  EXPECT_EQ(a.hits, b.hits);
  EXPECT_EQ(a.misses, b.misses);
  EXPECT_EQ(a.miss_bytes, b.miss_bytes);
  EXPECT_EQ(a.evictions, b.evictions);
  EXPECT_EQ(a.writebacks, b.writebacks);
  EXPECT_EQ(a.writeback_bytes, b.writeback_bytes);
  EXPECT_EQ(a.checkpoint_writes, b.checkpoint_writes);
  EXPECT_EQ(a.checkpoint_bytes, b.checkpoint_bytes);
  EXPECT_EQ(a.final_flush, b.final_flush);
  EXPECT_EQ(a.final_flush_bytes, b.final_flush_bytes);
}

void expect_the_slow_way_agrees(const Trace& trace, std::uint64_t arena) {
  using Rule = SlowArena::Rule;
  const auto compare = [&](const char* policy, Rule rule, std::uint64_t reach) {
    SCOPED_TRACE(policy);
    const auto fast = simulate(trace, policy, arena);
    ASSERT_TRUE(fast.ok() && fast->feasible);
    expect_same(*fast, SlowArena(trace, rule, reach, arena).run());
  };
  compare("lru", Rule::kLru, 0);
  compare("fifo", Rule::kFifo, 0);
  compare("belady", Rule::kBelady, PolicyChoice::kAll);
  compare("lookahead:1", Rule::kBelady, 1);
  compare("lookahead:7", Rule::kBelady, 7);
  compare("lookahead:1000", Rule::kBelady, 1000);
}

TEST(Simulate, RandomRequestsAsTheSlowWayHasThem) {
  for (std::uint64_t seed = 0; seed < 150 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    expect_the_slow_way_agrees(random_requests(seed, 200), 10 + seed % 60);
  }
}

TEST(Simulate, RandomGathersAsTheSlowWayHasThem) {
  for (std::uint64_t seed = 0; seed < 300 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    const Trace trace = random_gathers(seed, 40);
    expect_the_slow_way_agrees(trace, smallest_feasible_arena(trace, false) + seed % 12 * 4096);
  }
}

// Sizes of one kind: size × distance orders as distance does.
TEST(Simulate, BeladySizeIsBeladyWhereSizesAreEqual) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Trace trace = random_requests(seed, 200);
    for (const std::uint64_t arena : {2, 5, 9}) {
      const auto by_size = simulate(trace, "belady-size", arena, true);
      expect_same(*by_size, *simulate(trace, "belady", arena, true));
    }
  }
}

// c of 4 bytes, a, b of 1, d of 2 in 6. For d, Belady gives up b and a, which are farthest, and
// misses both; size × distance gives up c, 4 × 2 against 4 and 3, and misses that alone.
TEST(Simulate, BeladySizeGivesUpTheLargeOne) {
  Trace trace = requests_of("cabddcab");
  for (TraceEvent& event : trace.events)
    event.bytes = event.record == 2 ? 4 : event.record == 3 ? 2 : 1;
  EXPECT_EQ(simulate(trace, "belady-size", 6)->misses, 5u);
  EXPECT_EQ(simulate(trace, "belady", 6)->misses, 6u);
}

// Records that are requested and were not created in the trace.
std::uint64_t records_read_first(const Trace& trace) {
  std::set<RecordNumber> read, created;
  for (const TraceEvent& event : trace.events) {
    if (event.op == TraceOp::kCreate) created.insert(event.record);
    if (is_request(event.op) && !created.contains(event.record)) read.insert(event.record);
  }
  return read.size();
}

TEST(Simulate, UnderEveryPolicyAnArenaOfTheLeastSizeDoesAndALargeOneMissesOnce) {
  for (std::string policy : policy_names()) {
    if (policy.ends_with(":W")) policy.back() = '9';
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
      const Trace trace = random_gathers(seed, 60);
      const std::uint64_t smallest = smallest_feasible_arena(trace, false);
      const Simulation all = *simulate(trace, policy, 1 << 30);
      EXPECT_EQ(all.evictions, 0u);
      EXPECT_EQ(all.misses, records_read_first(trace));
      const Simulation least = *simulate(trace, policy, smallest);
      EXPECT_EQ(least.requests, request_count(trace));
      EXPECT_EQ(least.hits + least.misses, least.requests);
      EXPECT_GE(least.misses, all.misses);
    }
  }
}

// What the first iteration brought in is a hit in the second, and counted there alone.
TEST(Simulate, OneIterationIsCountedAfterWhatCameBefore) {
  Trace trace;
  trace.pins = true;
  trace.ids = {1};
  trace.sizes = {100};
  for (const std::uint64_t iteration : {std::uint64_t{1}, std::uint64_t{2}, kBetweenIterations}) {
    trace.events.push_back({TraceOp::kIteration, 0, iteration});
    trace.events.push_back({TraceOp::kRead, 0, 100});
    trace.events.push_back({TraceOp::kRelease, 0, 100});
  }
  const auto counted = [&](std::uint64_t iteration) {
    return *simulate(trace, "lru", kGranule, false, {}, iteration);
  };
  EXPECT_EQ(counted(1).misses, 1u);
  EXPECT_EQ(counted(2).requests, 1u);
  EXPECT_EQ(counted(2).hits, 1u);
  EXPECT_EQ(counted(CountedPart::kAll).requests, 3u);
}

}  // namespace
}  // namespace atrium
