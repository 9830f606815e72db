#include "solver/sample_sequence.h"

#include "engine/check.h"

namespace atrium {
namespace {

constexpr int kBits = 32;

// A primitive polynomial's degree and inner coefficients, and the first direction numbers.
struct Direction {
  int degree;
  std::uint32_t coefficients;
  std::array<std::uint32_t, 4> initial;
};

// Dimensions 2 to 6 of new-joe-kuo-6. [Joe & Kuo 2008]
constexpr std::array<Direction, kSobolDimensions - 1> kDirections{
    {{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}, {3, 2, {1, 1, 1}}, {4, 1, {1, 1, 3, 3}}}};

using Matrix = std::array<std::uint32_t, kBits>;

constexpr Matrix van_der_corput() {
  Matrix v{};
  for (int i = 0; i < kBits; ++i) v[i] = 1u << (kBits - 1 - i);
  return v;
}

constexpr Matrix generator(const Direction& d) {
  Matrix v{};
  for (int i = 0; i < kBits; ++i) {
    if (i < d.degree) {
      v[i] = d.initial[i] << (kBits - 1 - i);
      continue;
    }
    v[i] = v[i - d.degree] ^ (v[i - d.degree] >> d.degree);
    for (int k = 1; k < d.degree; ++k)
      if (d.coefficients >> (d.degree - 1 - k) & 1) v[i] ^= v[i - k];
  }
  return v;
}

constexpr std::array<Matrix, kSobolDimensions> generators() {
  std::array<Matrix, kSobolDimensions> all{};
  all[0] = van_der_corput();
  for (int d = 1; d < kSobolDimensions; ++d) all[d] = generator(kDirections[d - 1]);
  return all;
}

constexpr std::array<Matrix, kSobolDimensions> kGenerators = generators();

constexpr std::uint32_t reversed(std::uint32_t x) {
  x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
  x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
  x = (x >> 4 & 0x0f0f0f0fu) | (x & 0x0f0f0f0fu) << 4;
  return __builtin_bswap32(x);
}

// Owen's scramble of reversed bits: each bit is flipped by what stands before it. [Laine & Karras
// 2011, the constants Burley's]
constexpr std::uint32_t owen_scrambled(std::uint32_t x, std::uint32_t seed) {
  x += seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return x;
}

}  // namespace

void SobolTable::extend(std::uint32_t count) {
  for (std::uint32_t i = size(); i < count; ++i) {
    Reversed& point = points_.emplace_back();
    for (int d = 0; d < kSobolDimensions; ++d) {
      std::uint32_t x = 0;
      for (int bit = 0; i >> bit != 0; ++bit)
        if (i >> bit & 1) x ^= kGenerators[d][bit];
      point[d] = reversed(x);
    }
  }
}

SobolPoint SobolTable::scrambled(std::uint32_t index, std::uint64_t seed) const {
  constexpr double kUnit = 1.0 / (std::uint64_t{1} << kBits);
  ATRIUM_CHECK(index < points_.size());
  SobolPoint point;
  for (int d = 0; d < kSobolDimensions; d += 2) {
    const std::uint64_t seeds = derived(seed, static_cast<std::uint64_t>(d));
    for (int k = 0; k < 2; ++k) {
      const auto own = static_cast<std::uint32_t>(seeds >> (kBits * k));
      point[d + k] = (reversed(owen_scrambled(points_[index][d + k], own)) + 0.5) * kUnit;
    }
  }
  return point;
}

}  // namespace atrium
