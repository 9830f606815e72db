// Sample numbers: low-discrepancy points where how even they are counts, hashed random numbers
// elsewhere. Counter based: they follow from seeds and indices alone, whoever draws them and when.
//
//  - derived(): a seed from a seed. HashStream: random numbers. [SplitMix64, Steele, Lea & Flood
//    2014]
//  - SampleSequence: points of the unit square, of Sobol's sequence, Owen-scrambled by a seed: that
//    makes each point uniform by itself and sequences of different seeds independent, and keeps the
//    stratification. [Sobol' 1967; Owen 1995; Laine & Karras 2011]
//  - SobolTable: the same in more dimensions, for the first so many points.
//
// A SobolTable is immutable once built; a HashStream belongs to one thread; all else is pure.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/vec.h"

namespace atrium {

inline constexpr int kSobolDimensions = 6;

// Bits mixed until neighbours have nothing in common.
constexpr std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

inline constexpr std::uint64_t kGoldenStep = 0x9e3779b97f4a7c15ull;

// A seed for each pair of seed and number, as good as independent of all others.
constexpr std::uint64_t derived(std::uint64_t seed, std::uint64_t number) {
  return mixed(seed + kGoldenStep * (number + 1));
}

class HashStream {
 public:
  explicit HashStream(std::uint64_t seed = 0) : state_(seed) {}
  // In (0, 1).
  double uniform() {
    constexpr int kMantissa = 52;
    constexpr double kUnit = 1.0 / (std::uint64_t{1} << kMantissa);
    state_ += kGoldenStep;
    return (static_cast<double>(mixed(state_) >> (64 - kMantissa)) + 0.5) * kUnit;
  }

 private:
  std::uint64_t state_;
};

class SampleSequence {
 public:
  explicit SampleSequence(std::uint64_t seed) : seed_(seed) {}
  Vec2 at(std::uint32_t index) const;  // in (0, 1)²

 private:
  std::uint64_t seed_;
};

using SobolPoint = std::array<double, kSobolDimensions>;  // in (0, 1)

class SobolTable {
 public:
  explicit SobolTable(std::uint32_t count);

  // Its first two numbers are SampleSequence's. index: below `count`.
  SobolPoint scrambled(std::uint32_t index, std::uint64_t seed) const;

 private:
  using Reversed = std::array<std::uint32_t, kSobolDimensions>;  // the highest bit comes last
  std::vector<Reversed> points_;
};

}  // namespace atrium
