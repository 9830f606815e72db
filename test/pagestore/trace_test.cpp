#include "pagestore/trace.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "pagestore/record.h"
#include "test/pagestore/random_trace.h"

namespace atrium {
namespace {

TEST(Trace, ArenaChargeIsWholeGranulesWithTheHeaderOrAsItIs) {
  Trace trace;
  EXPECT_EQ(arena_charge(trace, 5000, false), 5000u);
  EXPECT_EQ(arena_charge(trace, 5000, true), 1u);
  trace.pins = true;
  EXPECT_EQ(arena_charge(trace, 4032, false), 4096u);  // 64 bytes of header
  EXPECT_EQ(arena_charge(trace, 4033, false), 8192u);
  EXPECT_EQ(arena_charge(trace, 4033, true), 1u);
}

TEST(Trace, NextRequestsCountRequestsOnly) {
  Trace trace;
  trace.pins = true;
  trace.ids = {7, 8};
  trace.sizes = {1, 1};
  for (const RecordNumber r : {0, 1, 0, 0, 1}) {
    trace.events.push_back({TraceOp::kRead, r, 1});
    trace.events.push_back({TraceOp::kRelease, r, 1});
  }
  EXPECT_EQ(request_count(trace), 5u);
  EXPECT_EQ(next_requests(trace), (std::vector<std::uint64_t>{2, 4, 3, kNeverAgain, kNeverAgain}));
}

TEST(Trace, SmallestArenaHoldsWhatIsPinnedAsItGrowsAndWhatIsCreatedBesideIt) {
  Trace trace;
  trace.pins = true;
  trace.ids = {1, 2, 3};
  trace.sizes = {100, 100, 0};
  trace.events = {{TraceOp::kRead, 0, 100}, {TraceOp::kRead, 0, 100}, {TraceOp::kRead, 1, 100}};
  EXPECT_EQ(smallest_feasible_arena(trace, false), 2 * kGranule);  // 0 counts once
  trace.events.push_back({TraceOp::kRelease, 0, 100});
  trace.events.push_back({TraceOp::kDirty, 1, 2 * kGranule});  // three granules, and 0 still there
  EXPECT_EQ(smallest_feasible_arena(trace, false), 4 * kGranule);
  trace.events.push_back({TraceOp::kRelease, 0, 100});
  trace.events.push_back({TraceOp::kCreate, 2, kGranule});  // two beside three
  EXPECT_EQ(smallest_feasible_arena(trace, false), 5 * kGranule);
  EXPECT_EQ(smallest_feasible_arena(trace, true), 2u);
}

TEST(Trace, SmallestArenaOfATraceWithoutPinsHoldsItsLargestRecord) {
  Trace trace;
  trace.ids = {1, 2};
  trace.sizes = {0, 0};
  trace.events = {{TraceOp::kGet, 0, 70}, {TraceOp::kPut, 1, 90}, {TraceOp::kGet, 0, 80}};
  EXPECT_EQ(smallest_feasible_arena(trace, false), 90u);
}

TEST(Trace, WhatNoStoreCanBeAskedIsFoundByEvent) {
  const auto place = [](bool pins, std::vector<TraceEvent> events) {
    Trace trace;
    trace.pins = pins;
    trace.ids = {1, 2};
    trace.sizes = {10, 10};
    trace.events = std::move(events);
    return check_trace(trace).place();
  };
  constexpr TraceEvent kRead{TraceOp::kRead, 0, 10}, kRelease{TraceOp::kRelease, 0, 10};
  EXPECT_EQ(place(true, {kRead, {TraceOp::kDirty, 0, 20}, kRelease, kRead, kRelease}), "");
  EXPECT_EQ(place(true, {{TraceOp::kIteration, 9, 3}, {TraceOp::kCheckpoint, 9}}), "");
  EXPECT_EQ(place(true, {kRead, kRelease, kRelease}), "event 2");
  EXPECT_EQ(place(true, {kRead, kRelease, {TraceOp::kDirty, 0, 20}}), "event 2");
  EXPECT_EQ(place(true, {kRead, {TraceOp::kRelease, 1, 10}}), "event 1");
  EXPECT_EQ(place(true, {kRead, {TraceOp::kCreate, 0, 10}}), "event 1");
  EXPECT_EQ(place(true, {{TraceOp::kCreate, 1, 1}, {TraceOp::kCreate, 1, 1}}), "event 1");
  EXPECT_EQ(place(true, {{TraceOp::kRead, 2, 10}}), "event 0");
  EXPECT_EQ(place(true, {{TraceOp::kGather, 2}}), "event 0");
  EXPECT_EQ(place(true, {{TraceOp::kGet, 0, 10}}), "event 0");
  EXPECT_EQ(place(false, {{TraceOp::kGet, 0, 10}, kRead}), "event 1");
  EXPECT_EQ(place(false, {{TraceOp::kPut, 0, 10}, {TraceOp::kCheckpoint}}), "event 1");
}

// A gather of `receiver` that reads the sources too.
void add_gather(Trace& trace, RecordNumber receiver, std::vector<RecordNumber> sources) {
  trace.events.push_back({TraceOp::kGather, receiver});
  sources.push_back(receiver);
  for (const RecordNumber r : sources) {
    trace.events.push_back({TraceOp::kRead, r, trace.sizes[r]});
    trace.events.push_back({TraceOp::kRelease, r, trace.sizes[r]});
  }
}

std::vector<RecordNumber> receivers(const Trace& trace) {
  std::vector<RecordNumber> found;
  for (const TraceEvent& event : trace.events)
    if (event.op == TraceOp::kGather) found.push_back(event.record);
  return found;
}

Trace two_iterations() {
  Trace trace;
  trace.pins = true;
  trace.ids = {40, 30, 20, 10};  // the model's order is the other way round
  trace.sizes = {1, 1, 1, 1};
  trace.events.push_back({TraceOp::kIteration, 0, 1});
  add_gather(trace, 0, {3});
  add_gather(trace, 1, {2});
  add_gather(trace, 3, {});
  trace.events.push_back({TraceOp::kCheckpoint});
  add_gather(trace, 2, {0, 3});
  trace.events.push_back({TraceOp::kIteration, 0, 2});
  add_gather(trace, 1, {});
  add_gather(trace, 0, {});
  return trace;
}

using Receivers = std::vector<RecordNumber>;

TEST(Reorder, EveryIterationByItself) {
  const Trace trace = two_iterations();
  EXPECT_EQ(receivers(*reorder(trace, "recorded", 0)), (Receivers{0, 1, 3, 2, 1, 0}));
  EXPECT_EQ(receivers(*reorder(trace, "reverse", 0)), (Receivers{2, 3, 1, 0, 0, 1}));
  EXPECT_EQ(receivers(*reorder(trace, "model", 0)), (Receivers{3, 2, 1, 0, 1, 0}));
  // From 0, with {0, 3}: 2 has two records in common with it, {2, 0, 3}; of that, 1 {1, 2} and
  // 3 {3} have one each, and 1 was recorded first; 3 is left.
  EXPECT_EQ(receivers(*reorder(trace, "nearest", 0)), (Receivers{0, 2, 1, 3, 1, 0}));
}

TEST(Reorder, RecordedIsTheTraceItselfAndCheckpointsKeepTheirPlace) {
  const Trace trace = two_iterations();
  const auto op_of = [](const TraceEvent& event) { return event.op; };
  const auto same = [](const TraceEvent& a, const TraceEvent& b) {
    return a.op == b.op && a.record == b.record && a.bytes == b.bytes;
  };
  EXPECT_TRUE(std::ranges::equal(reorder(trace, "recorded", 0)->events, trace.events, same));
  const Trace reversed = *reorder(trace, "reverse", 0);
  const auto checkpoint = std::ranges::find(reversed.events, TraceOp::kCheckpoint, op_of);
  EXPECT_EQ(std::count_if(reversed.events.begin(), checkpoint,
                          [](const TraceEvent& e) { return e.op == TraceOp::kGather; }),
            3);  // after the third gather, whichever that is
}

TEST(Reorder, RandomIsAPermutationThatItsSeedDecides) {
  Trace trace;
  trace.pins = true;
  for (RecordNumber r = 0; r < 50; ++r) {
    trace.ids.push_back(r);
    trace.sizes.push_back(1);
  }
  for (RecordNumber r = 0; r < 50; ++r) add_gather(trace, r, {});
  const Receivers once = receivers(*reorder(trace, "random", 1));
  EXPECT_EQ(once, receivers(*reorder(trace, "random", 1)));
  EXPECT_NE(once, receivers(*reorder(trace, "random", 2)));
  EXPECT_NE(once, receivers(trace));
  EXPECT_EQ(std::set<RecordNumber>(once.begin(), once.end()).size(), 50u);
}

TEST(Reorder, SizesFollowTheNewOrder) {
  Trace trace;
  trace.pins = true;
  trace.ids = {1, 2};
  trace.sizes = {10, 10};
  trace.events = {{TraceOp::kGather, 0},      {TraceOp::kRead, 0, 10}, {TraceOp::kDirty, 0, 90},
                  {TraceOp::kRelease, 0, 90}, {TraceOp::kGather, 1},   {TraceOp::kRead, 0, 90},
                  {TraceOp::kRelease, 0, 90}};
  const Trace reversed = *reorder(trace, "reverse", 0);
  EXPECT_EQ(reversed.events[1].bytes, 10u);  // the second gather's read comes first now
  EXPECT_EQ(reversed.events[2].bytes, 10u);
  EXPECT_EQ(reversed.events[6].bytes, 90u);
}

TEST(Reorder, TheRequestsOfRandomTracesStayTheSame) {
  int moved = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Trace trace = random_gathers(seed, 12);
    const auto requests = [](const Trace& t) {
      std::multiset<RecordNumber> records;
      for (const TraceEvent& event : t.events)
        if (is_request(event.op)) records.insert(event.record);
      return records;
    };
    for (const std::string& order : reorder_names()) {
      const auto reordered = reorder(trace, order, seed);
      // Made between gathers, a record may be read before it is there: that is refused.
      if (!reordered.ok()) {
        EXPECT_NE(order, "recorded");
        EXPECT_EQ(reordered.status().code(), Code::kUsage);
        continue;
      }
      EXPECT_EQ(requests(*reordered), requests(trace)) << order;
      EXPECT_EQ(reordered->events.size(), trace.events.size());
      moved += receivers(*reordered) != receivers(trace) ? 1 : 0;
    }
  }
  EXPECT_GT(moved, 50);  // of 250
}

TEST(Reorder, GathersThatHoldOnToEachOthersPinsAreNotParted) {
  Trace trace;
  trace.pins = true;
  trace.ids = {1};
  trace.sizes = {10};
  trace.events = {{TraceOp::kGather, 0},
                  {TraceOp::kRead, 0, 10},
                  {TraceOp::kGather, 0},
                  {TraceOp::kRelease, 0, 10}};
  EXPECT_EQ(reorder(trace, "reverse", 0).status().code(), Code::kUsage);
}

TEST(Reorder, NoSuchOrderOrNoGathers) {
  EXPECT_EQ(reorder(two_iterations(), "sideways", 0).status().code(), Code::kUsage);
  EXPECT_EQ(reorder(random_requests(1, 10), "random", 0).status().code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium
