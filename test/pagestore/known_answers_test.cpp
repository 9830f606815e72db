// Misses on a public trace, cloudphysics of libCacheSim (113,872 requests): the table of the facts,
// found by libCacheSim and by an independent implementation, equal in every cell.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <unordered_map>

#include "pagestore/simulate.h"

namespace atrium {
namespace {

const char* const kTraceFile = ATRIUM_SHARED_DIR "/traces/cloudphysics.oracleGeneral.bin";

// 24 bytes a request: u32 time, u64 id, u32 size, i64 next.
Trace cloudphysics() {
  constexpr std::size_t kEntry = 24, kIdAt = 4, kSizeAt = 12;
  std::ifstream file(kTraceFile, std::ios::binary);
  Trace trace;
  std::unordered_map<std::uint64_t, RecordNumber> numbers;
  for (char entry[kEntry]; file.read(entry, kEntry);) {
    std::uint64_t id;
    std::uint32_t size;
    std::memcpy(&id, entry + kIdAt, sizeof id);
    std::memcpy(&size, entry + kSizeAt, sizeof size);
    const auto [known, fresh] = numbers.emplace(id, static_cast<RecordNumber>(numbers.size()));
    if (fresh) {
      trace.ids.push_back(id);
      trace.sizes.push_back(0);
    }
    trace.events.push_back({TraceOp::kGet, known->second, size});
  }
  return trace;
}

struct Row {
  const char* policy;
  std::uint64_t misses[4];  // 128 MiB, 512 MiB, 500 records, 5000 records
};

constexpr Row kTable[] = {
    {"lru", {93374, 81722, 95398, 91527}},        {"fifo", {93403, 84025, 96483, 91581}},
    {"clock", {93313, 81328, 95293, 91458}},      {"sieve", {91699, 76707, 94379, 89798}},
    {"lfu", {91699, 76707, 96651, 89798}},        {"s3fifo", {89307, 76791, 94551, 85382}},
    {"arc-compat", {90252, 74297, 94218, 87770}}, {"2q", {91729, 77039, 94565, 87879}},
    {"belady", {79256, 61594, 90175, 71311}},     {"belady-size", {74237, 56509, 90175, 71311}}};

class KnownAnswers : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::ifstream(kTraceFile)) GTEST_SKIP() << "not there: " << kTraceFile;
    trace_ = cloudphysics();
  }
  std::uint64_t misses(const std::string& policy, std::uint64_t arena, bool unit_size) const {
    return simulate(trace_, policy, arena, unit_size)->misses;
  }
  Trace trace_;
};

constexpr std::uint64_t kMiB = 1 << 20;

TEST_F(KnownAnswers, TheTraceIsTheOneOfTheTable) {
  EXPECT_EQ(request_count(trace_), 113872u);
  EXPECT_EQ(trace_.ids.size(), 48974u);
}

TEST_F(KnownAnswers, TheWholeTable) {
  for (const Row& row : kTable) {
    SCOPED_TRACE(row.policy);
    EXPECT_EQ(misses(row.policy, 128 * kMiB, false), row.misses[0]);
    EXPECT_EQ(misses(row.policy, 512 * kMiB, false), row.misses[1]);
    EXPECT_EQ(misses(row.policy, 500, true), row.misses[2]);
    EXPECT_EQ(misses(row.policy, 5000, true), row.misses[3]);
  }
}

TEST_F(KnownAnswers, WhatHoldsEverythingMissesEveryRecordOnce) {
  for (const Row& row : kTable) EXPECT_EQ(misses(row.policy, 2048 * kMiB, false), 48974u);
}

// With all records of one size, a record's size as the step is the step of one.
TEST_F(KnownAnswers, ArcsStepsAreTheSameWhereSizesAre) {
  EXPECT_EQ(misses("arc", 500, true), misses("arc-compat", 500, true));
  EXPECT_NE(misses("arc", 512 * kMiB, false), misses("arc-compat", 512 * kMiB, false));
}

// A look-ahead over the whole trace is Belady's; none worth the name is LRU.
TEST_F(KnownAnswers, LookaheadLiesBetweenLruAndBelady) {
  const std::uint64_t arena = 512 * kMiB;
  EXPECT_EQ(misses("lookahead:113872", arena, false), 61594u);
  const std::uint64_t near = misses("lookahead:1000", arena, false);
  const std::uint64_t far = misses("lookahead:20000", arena, false);
  EXPECT_LT(near, 81722u);
  EXPECT_LT(far, near);
  EXPECT_GT(far, 61594u);
}

}  // namespace
}  // namespace atrium
