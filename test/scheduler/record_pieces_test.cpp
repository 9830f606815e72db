// What is written piece by piece comes back, whatever ends in which piece.
#include "scheduler/record_pieces.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>

#include "test/pagestore/simulated_disk.h"

namespace atrium::testing {
namespace {

constexpr RecordKind kKind = RecordKind::kOther;

class RecordPieces : public ::testing::Test {
 protected:
  RecordPieces() {
    auto made = ClusterStore::create("run", {.arena_bytes = kGranule, .disk = &disk_});
    EXPECT_TRUE(made.ok()) << made.status().message();
    store_ = std::move(made).value();
  }

  void write(std::uint32_t count) {
    std::vector<std::uint32_t> numbers(count);
    std::iota(numbers.begin(), numbers.end(), 0u);
    PiecesOut out(*store_, kKind);
    ASSERT_TRUE(out.put(std::span<const std::uint32_t>(&count, 1)).ok());
    ASSERT_TRUE(out.put(std::span<const std::uint32_t>(numbers)).ok());
    ASSERT_TRUE(out.finish().ok());
  }

  void expect_back(std::uint32_t count) {
    PiecesIn in(*store_, kKind);
    std::vector<std::uint32_t> head, numbers;
    ASSERT_TRUE(in.get(head, 1).ok());
    EXPECT_EQ(head[0], count);
    ASSERT_TRUE(in.get(numbers, count).ok());
    for (std::uint32_t i = 0; i < count; ++i) ASSERT_EQ(numbers[i], i);
    EXPECT_TRUE(in.finish().ok());
  }

  std::size_t records() const { return store_->record_ids().size(); }

  SimulatedDisk disk_;
  std::unique_ptr<ClusterStore> store_;
};

constexpr std::uint32_t kAPiece = kPieceBytes / sizeof(std::uint32_t);
static_assert(kPieceBytes % sizeof(std::uint32_t) == 0);

// The count and so many numbers: they fill a piece, end one short of it and one behind it.
TEST_F(RecordPieces, ArraysThatFillThemOrEndBesideTheirBordersComeBack) {
  for (const std::uint32_t numbers : {0u, kAPiece - 2, kAPiece - 1, kAPiece, 3 * kAPiece + 7}) {
    SCOPED_TRACE(numbers);
    write(numbers);
    EXPECT_EQ(records(), 1 + numbers / kAPiece);
    expect_back(numbers);
  }
}

TEST_F(RecordPieces, WhatWasLongerBeforeIsGone) {
  write(5 * kAPiece);
  EXPECT_EQ(records(), 6u);
  write(kAPiece);
  EXPECT_EQ(records(), 2u);
  expect_back(kAPiece);
  drop_pieces(*store_, kKind);
  EXPECT_FALSE(has_pieces(*store_, kKind));
  EXPECT_EQ(records(), 0u);
}

TEST_F(RecordPieces, MoreOrLessThanIsThereIsRefused) {
  write(kAPiece);
  std::vector<std::uint32_t> numbers;
  EXPECT_FALSE(PiecesIn(*store_, kKind).get(numbers, kAPiece + 2).ok());
  PiecesIn in(*store_, kKind);
  ASSERT_TRUE(in.get(numbers, kAPiece).ok());
  EXPECT_FALSE(in.finish().ok());
  store_->drop_streamed(record_id(kKind, 1));
  EXPECT_FALSE(PiecesIn(*store_, kKind).get(numbers, kAPiece + 1).ok());
}

}  // namespace
}  // namespace atrium::testing
