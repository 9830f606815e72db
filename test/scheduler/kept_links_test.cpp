// Kept links come back as they were, from memory and from disk, whatever the budget.
#include "scheduler/kept_links.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <memory>
#include <vector>

#include "scheduler/braid_record.h"
#include "test/pagestore/simulated_disk.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kReceivers = 3;

// One braid of `count` links of one coefficient each, which are told apart by the receiver.
std::vector<Braid> braids_to(std::uint32_t receiver, std::uint32_t count) {
  Braid braid;
  braid.source = ClusterId(receiver);
  braid.strands.push_back({.patch = 0, .links = count});
  for (std::uint32_t i = 0; i < count; ++i) {
    braid.links.push_back({{i, receiver, i}, .5f});
    braid.couplings.push_back(float(receiver) + 0.001f * float(i));
  }
  return {braid};
}

std::size_t bytes_in_use() {
  const auto heap = mallinfo2();
  return heap.uordblks + heap.hblkhd;
}

bool same(const std::vector<Braid>& a, const std::vector<Braid>& b) {
  return write_braids(a) == write_braids(b);
}

class KeptLinksOnDisk : public ::testing::Test {
 protected:
  KeptLinksOnDisk() {
    auto made = ClusterStore::create("run", {.arena_bytes = std::uint64_t{1} << 20, .disk = &disk_});
    EXPECT_TRUE(made.ok()) << made.status().message();
    store_ = std::move(made).value();
    for (std::uint32_t r = 0; r < kReceivers; ++r) order_.push_back(ClusterId(r));
  }

  SimulatedDisk disk_;
  std::unique_ptr<ClusterStore> store_;
  std::vector<ClusterId> order_;
};

TEST_F(KeptLinksOnDisk, WhatDoesNotFitComesBackFromDiskBitForBit) {
  KeptLinks links(*store_, kReceivers);
  ASSERT_TRUE(links.fit(~std::uint64_t{0}, order_).ok());
  for (std::uint32_t r = 0; r < kReceivers; ++r)
    ASSERT_TRUE(links.keep(ClusterId(r), braids_to(r, 100)).ok());
  EXPECT_EQ(links.kept().in_memory, kReceivers);
  const std::uint64_t one = links.kept().in_memory_bytes / kReceivers;

  ASSERT_TRUE(links.fit(one, order_).ok());  // the last two go to disk
  EXPECT_EQ(links.kept().in_memory, 1u);
  EXPECT_EQ(links.kept().streamed, 2u);
  for (std::uint32_t r = 0; r < kReceivers; ++r) {
    const Result<std::vector<Braid>*> back = links.of(ClusterId(r));
    ASSERT_TRUE(back.ok()) << back.status().message();
    EXPECT_TRUE(same(**back, braids_to(r, 100)));
  }
}

// Of a source that a braid holds verdicts of alone there is nothing to gather: its record need not be
// read. A doubt is light, and what an earlier process made is not known without looking.
TEST_F(KeptLinksOnDisk, BraidsOfVerdictsAloneCarryNoLight) {
  std::vector<Braid> braids(4);
  braids[1] = braids_to(0, 1).front();
  braids[2].verdicts.resize(1);
  braids[3].doubts.resize(1);
  KeptLinks links(*store_, kReceivers);
  for (const std::uint64_t budget : {~std::uint64_t{0}, std::uint64_t{0}}) {  // in memory, on disk
    ASSERT_TRUE(links.fit(budget, order_).ok());
    ASSERT_TRUE(links.keep(ClusterId(0u), braids).ok());
    for (const std::size_t i : {0u, 2u}) EXPECT_FALSE(links.carries_light(ClusterId(0u), i));
    for (const std::size_t i : {1u, 3u}) EXPECT_TRUE(links.carries_light(ClusterId(0u), i));
  }
  const KeptLinks taken_up(*store_, kReceivers);
  for (std::size_t i = 0; i < braids.size(); ++i)
    EXPECT_TRUE(taken_up.carries_light(ClusterId(0u), i));
}

// Braids without a link are nothing but their heads, and those of what is on disk are gone too.
TEST_F(KeptLinksOnDisk, WhatWentToDiskHoldsNoMemory) {
  constexpr std::size_t kBraids = 10000, kHeads = kBraids * sizeof(Braid);
  KeptLinks links(*store_, kReceivers);
  ASSERT_TRUE(links.fit(~std::uint64_t{0}, order_).ok());
  ASSERT_TRUE(links.keep(ClusterId(0u), std::vector<Braid>(kBraids)).ok());
  ASSERT_TRUE(links.save().ok());
  const std::size_t before = bytes_in_use();
  if (before < kHeads) GTEST_SKIP() << "this heap does not tell what is in use";
  ASSERT_TRUE(links.fit(0, order_).ok());
  EXPECT_LE(bytes_in_use(), before - kHeads);
}

// A finer level's braids take the place of the last one's, receiver by receiver, wherever either are.
TEST_F(KeptLinksOnDisk, TheLevelBeforeIsThereUntilItIsReplaced) {
  for (const std::uint64_t budget : {std::uint64_t{0}, ~std::uint64_t{0}}) {
    KeptLinks links(*store_, kReceivers);
    links.forget_all();
    ASSERT_TRUE(links.fit(budget, order_).ok());
    const ClusterId r(1u);
    EXPECT_TRUE(links.past(r).value().empty());
    ASSERT_TRUE(links.keep(r, braids_to(1, 10)).ok());
    EXPECT_TRUE(links.past(r).value().empty());
    links.become_past(r);
    EXPECT_FALSE(links.has(r));
    const std::span<const Braid> past = links.past(r).value();
    EXPECT_TRUE(same({past.begin(), past.end()}, braids_to(1, 10)));
    ASSERT_TRUE(links.keep(r, braids_to(1, 30)).ok());
    EXPECT_TRUE(links.has(r));
    EXPECT_TRUE(same(**links.of(r), braids_to(1, 30)));
    EXPECT_TRUE(links.past(r).value().empty());
    links.forget_all();
    EXPECT_EQ(links.kept().in_memory_bytes + links.kept().streamed_bytes, 0u);
  }
}

TEST_F(KeptLinksOnDisk, WhereTheNewOnesCannotBeWrittenTheLastOnesStay) {
  KeptLinks links(*store_, kReceivers);
  ASSERT_TRUE(links.fit(0, order_).ok());
  const ClusterId r(1u);
  ASSERT_TRUE(links.keep(r, braids_to(1, 10)).ok());
  links.become_past(r);
  disk_.capacity = disk_.used();
  EXPECT_FALSE(links.keep(r, braids_to(1, 1 << 20)).ok());
  const Result<std::span<const Braid>> past = links.past(r);
  ASSERT_TRUE(past.ok()) << past.status().message();
  EXPECT_TRUE(same({past->begin(), past->end()}, braids_to(1, 10)));
}

TEST_F(KeptLinksOnDisk, WhatIsForgottenIsMadeAnew) {
  KeptLinks links(*store_, kReceivers);
  ASSERT_TRUE(links.fit(0, order_).ok());  // all are streamed
  for (std::uint32_t r = 0; r < kReceivers; ++r)
    ASSERT_TRUE(links.keep(ClusterId(r), braids_to(r, 10)).ok());
  EXPECT_EQ(links.kept().streamed, kReceivers);
  links.forget(ClusterId(1u));
  EXPECT_TRUE(links.has(ClusterId(0u)));
  EXPECT_FALSE(links.has(ClusterId(1u)));
  links.forget_all();
  EXPECT_FALSE(links.has(ClusterId(2u)));
  EXPECT_EQ(links.kept().in_memory_bytes + links.kept().streamed_bytes, 0u);
}

}  // namespace
}  // namespace atrium::testing
