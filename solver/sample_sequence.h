// Sample numbers for path tracing: low-discrepancy points for what is decided at a path's start,
// hashed random numbers for what comes later. Counter based: the numbers of a path follow from its
// seeds alone, whoever draws them and when.
//
//  - SobolTable: the first points of Sobol's sequence, unscrambled. [Joe & Kuo 2008]
//  - scrambled(): a point of it, Owen-scrambled by a seed, which makes each point uniform over the
//    cube and keeps the set's stratification. [Burley 2020, Practical Hash-based Owen Scrambling]
//  - HashStream: random numbers. [splitmix64, Steele, Lea & Flood 2014]
//
// A SobolTable is immutable once built; a HashStream belongs to one thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace atrium {

inline constexpr int kSobolDimensions = 6;

// Bits mixed until neighbours have nothing in common.
constexpr std::uint64_t mixed(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

inline constexpr std::uint64_t kGoldenStep = 0x9e3779b97f4a7c15ull;

// A seed that follows from another and a number.
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

using SobolPoint = std::array<double, kSobolDimensions>;  // in (0, 1)

class SobolTable {
 public:
  explicit SobolTable(std::uint32_t count = 0) { extend(count); }
  // Points below `count` are there from now on.
  void extend(std::uint32_t count);
  std::uint32_t size() const { return static_cast<std::uint32_t>(points_.size()); }

  SobolPoint scrambled(std::uint32_t index, std::uint64_t seed) const;

 private:
  using Reversed = std::array<std::uint32_t, kSobolDimensions>;  // the highest bit comes last
  std::vector<Reversed> points_;
};

}  // namespace atrium
