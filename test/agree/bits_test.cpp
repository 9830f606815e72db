// The same bits for any number of threads, any arena, policy and memory, and either way to the disk.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "pagestore/policy.h"
#include "test/agree/scenes.h"

namespace atrium::testing {
namespace {

// Four rooms joined by doorways, three boxes in each; and one run of it to compare with.
class SameBits : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    bench_ = std::make_unique<Bench>(generated({.kind = "rooms", .grid = 2}));
    SolvedRun run(options());
    ASSERT_TRUE(run.ok());
    records_ = run.records();
    summary_ = run.summary();
    std::size_t bytes = 0;
    for (const Record& r : records_) bytes += r.size();
    ASSERT_GT(bytes, 100000u);  // that there is something to compare
  }
  static void TearDownTestSuite() { bench_.reset(); }

  static SolveOptions options() {
    SolveOptions o = bench_->options();
    o.error = 0.05;
    o.threads = 1;
    o.arena = std::uint64_t{256} << 20;
    return o;
  }

  static SolveSummary expect_same(const SolveOptions& o) {
    SolvedRun run(o);
    EXPECT_TRUE(run.ok());
    if (!run.ok()) return {};
    const std::vector<Record> records = run.records();
    EXPECT_EQ(records.size(), records_.size());
    for (std::size_t c = 0; c < std::min(records.size(), records_.size()); ++c)
      EXPECT_TRUE(records[c] == records_[c]) << "cluster " << c;
    EXPECT_EQ(run.summary().iterations, summary_.iterations);
    EXPECT_EQ(run.summary().flux_absorbed, summary_.flux_absorbed);
    return run.summary();
  }

  using Record = std::vector<std::byte>;
  static inline std::unique_ptr<Bench> bench_;
  static inline std::vector<Record> records_;
  static inline SolveSummary summary_;
};

TEST_F(SameBits, OnceMore) { expect_same(options()); }

TEST_F(SameBits, TwoThreeAndEightThreads) {
  for (const int threads : {2, 3, 8}) {
    SCOPED_TRACE(threads);
    SolveOptions o = options();
    o.threads = threads;
    expect_same(o);
  }
}

// In the smallest arena that will do records come and go all the time, whoever chooses them.
TEST_F(SameBits, TinyArenaUnderEveryPolicy) {
  EXPECT_EQ(summary_.evictions, 0u);
  for (std::string policy : policy_names()) {
    if (policy.ends_with(":W")) policy.back() = '9';
    SCOPED_TRACE(policy);
    SolveOptions o = options();
    o.policy = policy;
    o.arena = 0;
    const Result<Plan> planned = plan(o);
    ASSERT_TRUE(planned.ok()) << planned.status().message();
    o.arena = planned->smallest_arena;
    const SolveSummary s = expect_same(o);
    EXPECT_GT(s.evictions, 0u);
    EXPECT_LT(s.hit_ratio, 1);
  }
}

TEST_F(SameBits, PastThePageCache) {
  SolveOptions o = options();
  o.io = "direct";
  expect_same(o);
}

// In the least memory that will do links go to disk when they are made, and come from there in
// every sweep; with as much as the others have none does.
TEST_F(SameBits, BraidsStreamedInTheLeastMemoryThatWillDo) {
  SolveOptions o = options();
  o.arena = 0;
  const Result<Plan> planned = plan(o);
  ASSERT_TRUE(planned.ok()) << planned.status().message();
  o.memory = planned->smallest_memory;
  const SolveSummary s = expect_same(o);
  EXPECT_GT(s.links_kept.streamed, s.links_kept.in_memory);
  EXPECT_GT(s.streamed_bytes_read, 0u);
  EXPECT_EQ(summary_.links_kept.streamed, 0u);
}

// A furnished office has face groups, whose light comes a sweep later, and patches enough in a
// cluster for threads to share.
TEST(SameBitsOfAnOffice, ThreadsArenaAndWayToTheDisk) {
  Bench bench(generated({.kind = "office-high"}));
  const auto solved = [&](int threads, bool small, const char* io) {
    SolveOptions o = bench.options();
    o.error = 0.3;
    o.iterations = 4;
    o.threads = threads;
    o.io = io;
    if (small) o.memory = plan(o).value().smallest_memory;
    SolvedRun run(o);
    EXPECT_TRUE(run.ok());
    return run.ok() ? run.records() : std::vector<std::vector<std::byte>>{};
  };
  const auto expected = solved(1, false, "mmap");
  ASSERT_FALSE(expected.empty());
  EXPECT_TRUE(solved(3, false, "mmap") == expected);
  EXPECT_TRUE(solved(2, true, "direct") == expected);
}

// A convex room with nothing in it needs no rays; asking for them changes no bit.
TEST(LeftOut, AConvexEmptyRoomWithAndWithoutRays) {
  Bench bench(generated({.kind = "furnace", .rho = 0.5, .exitance = 100, .shape = "cube"}));
  SolvedRun without(bench.options());
  SolveOptions forced = bench.options();
  forced.force = {"rays"};
  SolvedRun with(forced);
  ASSERT_TRUE(without.ok() && with.ok());
  const auto rays_left_out = [](const SolveSummary& s) {
    return std::any_of(s.left_out.begin(), s.left_out.end(),
                       [](const LeftOut& l) { return l.feature == "rays"; });
  };
  EXPECT_TRUE(rays_left_out(without.summary()));
  EXPECT_FALSE(rays_left_out(with.summary()));
  const auto a = without.records(), b = with.records();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t c = 0; c < a.size(); ++c) EXPECT_TRUE(a[c] == b[c]) << "cluster " << c;
}

TEST(LeftOut, RaysStayWhereALampHangsFreely) {
  Bench bench(generated({.kind = "cornell"}));
  const Result<Plan> planned = plan(bench.options());
  ASSERT_TRUE(planned.ok());
  for (const LeftOut& l : planned->left_out) EXPECT_NE(l.feature, "rays");
}

bool groups_left_out(const SolveOptions& options) {
  const Result<Plan> planned = plan(options);
  EXPECT_TRUE(planned.ok()) << planned.status().message();
  return planned.ok() && std::ranges::any_of(planned->left_out, [](const LeftOut& l) {
           return l.feature == "groups";
         });
}

// Boxes of five faces have none to group; an office's bookcases, chairs and keyboards have
// hundreds.
TEST(LeftOut, GroupsWhereNoClusterIsDense) {
  Bench boxes(generated({.kind = "cornell"}));
  EXPECT_TRUE(groups_left_out(boxes.options()));
  Bench office(generated({.kind = "office-low"}));
  EXPECT_FALSE(groups_left_out(office.options()));
}

TEST(LeftOut, GroupsCanBeForcedAndNoOtherWord) {
  Bench bench(generated({.kind = "rooms", .grid = 1}));
  SolveOptions forced = bench.options();
  forced.force = {"groups"};
  ASSERT_TRUE(plan(forced).ok());
  forced.force = {"grouping"};
  EXPECT_FALSE(plan(forced).ok());
}

}  // namespace
}  // namespace atrium::testing
