// Which light, and with what probability: what is told must be what is drawn, and no light that
// could send anything may be beyond reach.
#include "solver/light_choice.h"

#include <gtest/gtest.h>

#include <random>

#include "solver/form_factor.h"
#include "solver/sample_sequence.h"

namespace atrium {
namespace {

struct Lights {
  std::vector<Polygon> polygons;
  std::vector<LightOutline> outlines;
};

// Squares of many sizes and directions in a cube of 10 m, each third of them two-sided.
Lights scattered_lights(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(0, 10), side(-1, 1), size(0.01, 1);
  Lights lights;
  for (int i = 0; i < count; ++i) {
    const Vec3 c{coordinate(random), coordinate(random), coordinate(random)};
    const Vec3 a{side(random), side(random), side(random)};
    const Vec3 u = normalize(cross(a, Vec3{0.3, 0.5, 0.8})), v = normalize(cross(a, u));
    const double s = size(random);
    lights.polygons.push_back({c, c + s * u, c + s * u + s * v, c + s * v});
  }
  for (int i = 0; i < count; ++i) {
    const Polygon& p = lights.polygons[i];
    lights.outlines.push_back({p, area(p) * (1 + i % 5), normalize(area_vector(p)), i % 3 == 0});
  }
  return lights;
}

std::vector<SurfacePoint> scattered_points(int count) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> coordinate(0, 10), side(-1, 1);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < count; ++i) {
    const Vec3 x{coordinate(random), coordinate(random), coordinate(random)};
    points.push_back({x, normalize(Vec3{side(random), side(random), side(random)})});
  }
  return points;
}

// Does the light send anything to the point, going by its closed form?
bool reaches(const LightOutline& light, const SurfacePoint& p) {
  if (point_to_polygon(p.x, p.normal, light.polygon) > 0) return true;
  if (!light.two_sided) return false;
  const Polygon back(light.polygon.rbegin(), light.polygon.rend());
  return point_to_polygon(p.x, p.normal, back) > 0;
}

// Draws at even steps of u hit each light as often as its probability says; one step more or less
// where its part of (0, 1) begins and ends, and it has one part in the tree and one behind it.
template <class Choose, class Probability>
void expect_draws_as_told(std::size_t lights, Choose choose, Probability probability) {
  constexpr int kSteps = 20000;
  std::vector<int> drawn(lights);
  for (int i = 0; i < kSteps; ++i)
    if (const auto chosen = choose((i + 0.5) / kSteps)) {
      EXPECT_NEAR(chosen->probability, probability(chosen->light), 1e-12);
      ++drawn[chosen->light];
    }
  for (std::uint32_t l = 0; l < lights; ++l)
    EXPECT_NEAR(drawn[l], kSteps * probability(l), 2.001) << "light " << l;
}

TEST(LightTree, DrawsAsTold) {
  const Lights lights = scattered_lights(37);
  const LightTree tree(lights.outlines);
  for (const SurfacePoint& p : scattered_points(20))
    expect_draws_as_told(
        lights.outlines.size(), [&](double u) { return tree.choose(p.x, p.normal, u); },
        [&](std::uint32_t l) { return tree.probability(p.x, p.normal, l); });
}

TEST(LightTree, NoLightThatReachesAPointIsBeyondReach) {
  for (const int count : {1, 2, 3, 50}) {
    const Lights lights = scattered_lights(count);
    const LightTree tree(lights.outlines);
    int reached = 0;
    for (const SurfacePoint& p : scattered_points(2000))
      for (std::uint32_t l = 0; l < lights.outlines.size(); ++l) {
        if (!reaches(lights.outlines[l], p)) continue;
        ++reached;
        EXPECT_GT(tree.probability(p.x, p.normal, l), 0);
      }
    EXPECT_GT(reached, 100);
  }
}

TEST(LightTree, NearLightsGoBeforeFarOnes) {
  // Two equal lamps over a floor point, 1 m and 10 m away: by 1/d², 100 to 1.
  const auto lamp = [](double z) {
    return Polygon{{-.1, -.1, z}, {-.1, .1, z}, {.1, .1, z}, {.1, -.1, z}};
  };
  const Polygon near = lamp(1), far = lamp(10);
  const std::vector<LightOutline> outlines{{near, 1, {0, 0, -1}, false},
                                           {far, 1, {0, 0, -1}, false}};
  const LightTree tree(outlines);
  EXPECT_NEAR(tree.probability({0, 0, 0}, {0, 0, 1}, 0), 100.0 / 101, 1e-3);
  EXPECT_FALSE(tree.choose({0, 0, 0}, {0, 0, -1}, 0.5));
}

TEST(LightChoice, WhatWasLearntIsDrawnAsToldAndLeavesNoLightBeyondReach) {
  const Lights lights = scattered_lights(12);
  LightChoice choice(lights.outlines);
  // All that gave anything is light 3, and light 5 a third of it, everywhere.
  std::vector<LightRecord> records;
  for (const SurfacePoint& p : scattered_points(400)) {
    records.push_back({p.x, p.normal, 3, 3});
    records.push_back({p.x, p.normal, 5, 1});
  }
  choice.learn(records, 600);
  const LightTree tree(lights.outlines);
  for (const SurfacePoint& p : scattered_points(20)) {
    const auto region = choice.region(p.x, p.normal);
    const auto probability = [&](std::uint32_t l) {
      return choice.probability(region, p.x, p.normal, l);
    };
    expect_draws_as_told(
        lights.outlines.size(), [&](double u) { return choice.choose(region, p.x, p.normal, u); },
        probability);
    EXPECT_NEAR(probability(3) - probability(5) * 3,
                .25 * (tree.probability(p.x, p.normal, 3) - 3 * tree.probability(p.x, p.normal, 5)),
                1e-12);
    EXPECT_GT(probability(3), 0.5);
    for (std::uint32_t l = 0; l < lights.outlines.size(); ++l)
      EXPECT_GE(probability(l), reaches(lights.outlines[l], p) ? 1e-12 : 0.0);
  }
}

TEST(SobolTable, PowersOfTwoFillEveryStratumOnce) {
  constexpr int kPoints = 64, kSide = 8;
  const SobolTable table(kPoints);
  for (const std::uint64_t seed : {1u, 2u, 77u}) {
    std::array<std::array<int, kPoints>, kSobolDimensions> strata{};
    std::array<int, kSide * kSide> squares{};
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const SobolPoint p = table.scrambled(i, seed);
      for (int d = 0; d < kSobolDimensions; ++d) ++strata[d][static_cast<int>(p[d] * kPoints)];
      ++squares[static_cast<int>(p[0] * kSide) * kSide + static_cast<int>(p[1] * kSide)];
    }
    for (const auto& axis : strata)
      for (const int count : axis) EXPECT_EQ(count, 1);
    for (const int count : squares) EXPECT_EQ(count, 1);
  }
}

TEST(SampleSequence, IsTheTablesFirstTwoDimensions) {
  constexpr std::uint32_t kPoints = 100;
  const SobolTable table(kPoints);
  for (const std::uint64_t seed : {0u, 5u})
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const SobolPoint p = table.scrambled(i, seed);
      EXPECT_EQ(SampleSequence(seed).at(i), Vec2(p[0], p[1]));
    }
}

// A (0,2)-sequence: of each run of 2^k points from a multiple of 2^k on, every elementary interval
// holds one, whatever its shape.
TEST(SampleSequence, EveryElementaryIntervalHoldsOnePoint) {
  constexpr std::uint32_t kLevels = 8, kPoints = 1u << kLevels, kFar = 1u << 20;
  for (const std::uint32_t first : {0u, kPoints, kFar})
    for (std::uint32_t level = 0; level <= kLevels; ++level) {
      const std::uint32_t columns = 1u << level, rows = kPoints / columns;
      std::vector<int> held(kPoints);
      for (std::uint32_t i = first; i < first + kPoints; ++i) {
        const Vec2 p = SampleSequence(3).at(i);
        ++held[static_cast<std::uint32_t>(p.x * columns) * rows +
               static_cast<std::uint32_t>(p.y * rows)];
      }
      EXPECT_EQ(held, std::vector<int>(kPoints, 1)) << columns << " columns from " << first;
    }
}

// Where a point falls, over many seeds, is uniform: 64 squares, chi squared of 63 degrees. It
// stays below 117 in all but one of 20,000 tries.
TEST(SampleSequence, EachPointIsUniformOverSeeds) {
  constexpr int kSide = 8, kSquares = kSide * kSide, kSeeds = 200 * kSquares;
  for (const std::uint32_t i : {0u, 1u, 2u, 37u, 1023u}) {
    std::vector<double> held(kSquares);
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Vec2 p = SampleSequence(seed).at(i);
      ++held[static_cast<int>(p.x * kSide) * kSide + static_cast<int>(p.y * kSide)];
    }
    constexpr double kExpected = double(kSeeds) / kSquares;
    double chi_squared = 0;
    for (const double n : held) chi_squared += (n - kExpected) * (n - kExpected) / kExpected;
    EXPECT_LT(chi_squared, 117) << "point " << i;
  }
}

}  // namespace
}  // namespace atrium
