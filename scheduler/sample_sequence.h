// Points of the unit square that are spread evenly from the first on: a (0,2)-sequence, scrambled
// after Owen, so that each point is uniform by itself and sequences of different keys are
// independent. [Sobol' 67; Owen 95; Laine & Karras 11; Burley 20]
// Pure functions, any thread.
#pragma once

#include <cstdint>

#include "engine/geometry.h"

namespace atrium {

// A key for each pair of key and number, as good as independent of all others. [SplitMix64]
std::uint64_t mixed(std::uint64_t key, std::uint64_t number);

class SampleSequence {
 public:
  explicit SampleSequence(std::uint64_t key);
  Vec2 at(std::uint32_t i) const;  // in [0, 1)²

 private:
  std::uint32_t first_, second_;  // of each dimension's scrambling
};

// Cosine-weighted about n, the first two axes any: the square's point lifted from the disc.
// [Malley]
struct Hemisphere {
  explicit Hemisphere(const Vec3& normal);
  Vec3 cosine_direction(const Vec2& square) const;  // unit

 private:
  Frame frame_;
};

// Uniform by area over a convex polygon, even where the square's points are.
Vec3 point_of(PolygonView polygon, const Vec2& square);

}  // namespace atrium
