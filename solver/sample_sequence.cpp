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

// Bits of a point in one dimension, the highest last.
constexpr std::uint32_t sobol(int dimension, std::uint32_t index) {
  std::uint32_t x = 0;
  for (int bit = 0; bit < kBits && index >> bit != 0; ++bit)
    if (index >> bit & 1) x ^= kGenerators[dimension][bit];
  return reversed(x);
}

// Owen's scramble of reversed bits: each bit is flipped by what stands before it. [Laine & Karras
// 2011; steps and constants of Vegdahl 2021, Building a Better LK Hash]
constexpr std::uint32_t owen_scrambled(std::uint32_t x, std::uint32_t seed) {
  x ^= x * 0x3d20adeau;
  x += seed;
  x *= (seed >> 16) | 1;
  x ^= x * 0x05526c56u;
  x ^= x * 0x53a22864u;
  return x;
}

double fraction(std::uint32_t reversed_bits, std::uint32_t seed) {
  constexpr double kUnit = 1.0 / (std::uint64_t{1} << kBits);
  return (reversed(owen_scrambled(reversed_bits, seed)) + 0.5) * kUnit;
}

// Dimensions 2 × pair and the one after it, scrambled.
Vec2 scrambled_pair(std::uint32_t x, std::uint32_t y, std::uint64_t seed, int pair) {
  const std::uint64_t seeds = derived(seed, static_cast<std::uint64_t>(pair));
  return {fraction(x, static_cast<std::uint32_t>(seeds)),
          fraction(y, static_cast<std::uint32_t>(seeds >> kBits))};
}

}  // namespace

// The second dimension's bits: its matrix is Pascal's triangle of odd and even, which is a product
// of five sparse ones.
constexpr std::uint32_t pascal(std::uint32_t x) {
  x ^= x >> 1 & 0x55555555u;
  x ^= x >> 2 & 0x33333333u;
  x ^= x >> 4 & 0x0f0f0f0fu;
  x ^= x >> 8 & 0x00ff00ffu;
  x ^= x >> 16;
  return x;
}
static_assert([] {
  for (int bit = 0; bit < kBits; ++bit)
    if (sobol(0, 1u << bit) != 1u << bit || sobol(1, 1u << bit) != pascal(1u << bit)) return false;
  return true;
}());

Vec2 SampleSequence::at(std::uint32_t index) const {
  return scrambled_pair(index, pascal(index), seed_, 0);
}

SobolTable::SobolTable(std::uint32_t count) : points_(count) {
  for (std::uint32_t i = 0; i < count; ++i)
    for (int d = 0; d < kSobolDimensions; ++d) points_[i][d] = sobol(d, i);
}

SobolPoint SobolTable::scrambled(std::uint32_t index, std::uint64_t seed) const {
  ATRIUM_CHECK(index < points_.size());
  SobolPoint point;
  for (int d = 0; d < kSobolDimensions; d += 2) {
    const Vec2 pair = scrambled_pair(points_[index][d], points_[index][d + 1], seed, d / 2);
    point[d] = pair.x;
    point[d + 1] = pair.y;
  }
  return point;
}

}  // namespace atrium
