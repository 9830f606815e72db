// Random numbers that are the same on every machine: splitmix64 [Steele, Lea, Flood 2014] started
// from a seed and a label, so that what one part of a model draws never shifts another's draws.
#pragma once

#include <cstdint>
#include <string_view>

namespace atrium::generator {

class Dice {
 public:
  Dice(std::uint64_t seed, std::string_view label) : state_(seed) {
    for (char c : label) state_ = (state_ ^ static_cast<unsigned char>(c)) * kFnvPrime;
    next();
  }
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  // Uniform in [lo, hi).
  double uniform(double lo, double hi) {
    constexpr double kUnit = 1.0 / (std::uint64_t{1} << 53);
    return lo + (hi - lo) * static_cast<double>(next() >> 11) * kUnit;
  }
  // Uniform among lo, lo + 1, …, hi.
  int integer(int lo, int hi) {
    return lo + static_cast<int>(next() % static_cast<std::uint64_t>(hi - lo + 1));
  }

 private:
  static constexpr std::uint64_t kFnvPrime = 0x100000001b3ull;
  std::uint64_t state_;
};

}  // namespace atrium::generator
