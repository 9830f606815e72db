// How often records were requested lately, roughly: a count-min sketch of four rows with counters
// of four bits. A request raises only those of its counters that are least (minimal increment);
// after every ten requests a record in the arena, all counters are halved, so that the past fades.
// [Einziger, Friedman, Manes, "TinyLFU: A Highly Efficient Cache Admission Policy", ACM ToS 2017]
//
// A row has at least one counter a record in the arena: it doubles as they become more, and every
// estimate stays what it was. Deterministic. Not thread safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "pagestore/policy.h"

namespace atrium {

class FrequencySketch {
 public:
  void count(RecordNumber record) {
    const std::uint32_t least = estimate(record);
    for (std::size_t row = 0; row < kRows; ++row) {
      const Place at = place(row, record);
      if (least < kMostCount && count_at(at) == least) words_[at.word] += at.one;
    }
    if (++counted_ >= kRequestsPerRecord * std::max(records_, kLeastWidth)) halve();
  }

  std::uint32_t estimate(RecordNumber record) const {
    std::uint32_t least = kMostCount;
    for (std::size_t row = 0; row < kRows; ++row)
      least = std::min(least, count_at(place(row, record)));
    return least;
  }

  // How many records are in the arena.
  void fit(std::size_t records) {
    records_ = records;
    while (width_ < records) widen();
  }

 private:
  static constexpr std::size_t kRows = 4;
  static constexpr std::size_t kLeastWidth = 1024;       // counters a row; a power of two
  static constexpr std::size_t kRequestsPerRecord = 10;  // from one halving to the next
  static constexpr std::uint32_t kCounterBits = 4;
  static constexpr std::uint32_t kMostCount = (1u << kCounterBits) - 1;
  static constexpr std::size_t kCountersPerWord = 64 / kCounterBits;
  static constexpr std::uint64_t kHalfMask = 0x7777777777777777u;  // no bit enters from a neighbour
  // Odd, from splitmix64: multiplied, they scatter consecutive numbers over the upper bits.
  static constexpr std::array<std::uint64_t, kRows> kScatter = {
      0x9e3779b97f4a7c15u, 0xbf58476d1ce4e5b9u, 0x94d049bb133111ebu, 0xd6e8feb86659fd93u};

  struct Place {
    std::size_t word;
    std::uint32_t shift;
    std::uint64_t one;  // of its counter
  };

  Place place(std::size_t row, RecordNumber record) const {
    const std::uint64_t hash = ((record + std::uint64_t{1}) * kScatter[row]) >> 32;
    const std::size_t counter = row * width_ + (hash & (width_ - 1));
    const auto shift = static_cast<std::uint32_t>(counter % kCountersPerWord) * kCounterBits;
    return {counter / kCountersPerWord, shift, std::uint64_t{1} << shift};
  }
  std::uint32_t count_at(const Place& at) const {
    return static_cast<std::uint32_t>(words_[at.word] >> at.shift) & kMostCount;
  }

  void halve() {
    for (std::uint64_t& word : words_) word = (word >> 1) & kHalfMask;
    counted_ /= 2;
  }

  // Twice each row's counters: a hash's next bit picks one of two that start alike.
  void widen() {
    const std::size_t row_words = width_ / kCountersPerWord;
    std::vector<std::uint64_t> wide;
    for (std::size_t row = 0; row < kRows; ++row) {
      const auto begin = words_.begin() + static_cast<std::ptrdiff_t>(row * row_words);
      const auto end = begin + static_cast<std::ptrdiff_t>(row_words);
      wide.insert(wide.end(), begin, end);
      wide.insert(wide.end(), begin, end);
    }
    words_ = std::move(wide);
    width_ *= 2;
  }

  std::size_t width_ = kLeastWidth;
  std::vector<std::uint64_t> words_ =
      std::vector<std::uint64_t>(kRows * kLeastWidth / kCountersPerWord);
  std::size_t records_ = 0;
  std::size_t counted_ = 0;  // since the last halving, and half of those before
};

}  // namespace atrium
