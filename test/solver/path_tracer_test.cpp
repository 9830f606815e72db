// The path tracer against closed forms. What it finds is held to four of its own standard errors,
// and those to what so many paths must reach, so that neither can hide behind the other.
#include "solver/path_tracer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "solver/reference.h"
#include "test/visibility/scene_builder.h"

namespace atrium {
namespace {

constexpr double kSigmas = 4;

// Both of SceneBuilder's materials.
Scene with_materials(Scene scene, const Spectrum& reflectance, const Spectrum& lamp,
                     const Spectrum& grey = Spectrum{0}) {
  for (Material& m : scene.materials) m.reflectance = reflectance;
  scene.materials[0].exitance = grey;
  scene.materials[1].exitance = lamp;
  return scene;
}

std::vector<ReferencePoint> traced(const Scene& scene, const std::vector<SurfacePoint>& points,
                                   std::uint64_t paths, std::uint64_t seed = 1) {
  PathTracer tracer(scene, seed);
  return trace_reference(tracer, points, {.paths = paths}, {}).points;
}

void expect_found(const ReferencePoint& found, const Spectrum& expected, double relative_error) {
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(found.irradiance[c], expected[c], kSigmas * found.standard_error[c] + 1e-12);
    EXPECT_LE(found.standard_error[c], relative_error * expected[c]);
  }
}

TEST(PathTracer, UnderASquareLampMatchesTheConfigurationFactor) {
  const Spectrum m{100, 10, 1e-4};
  for (const double height : {2.0, 0.5, 0.01}) {
    const Polygon lamp{{-.5, -.5, height}, {-.5, .5, height}, {.5, .5, height}, {.5, -.5, height}};
    SceneBuilder s;
    s.quad("floor", {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}).polygon("lamp", lamp, kFront, true);
    const Scene scene = with_materials(s.build(), Spectrum{0}, m);
    std::vector<SurfacePoint> points;
    for (const double x : {0.0, 0.3, 0.499, 0.501, 0.6, 1.5})
      points.push_back({{x, x / 3, 0}, {0, 0, 1}});
    const auto found = traced(scene, points, 4096);
    for (std::size_t i = 0; i < points.size(); ++i) {
      SCOPED_TRACE("height " + std::to_string(height) + ", point " + std::to_string(i));
      // Plain sampling by area alone is off by 100% and more at 1 cm.
      expect_found(found[i], m * point_to_polygon(points[i].x, {0, 0, 1}, lamp), 0.05);
    }
  }
}

// All surfaces ρ and M: E = M/(1-ρ) everywhere, whatever the shape.
void expect_furnace(const SceneBuilder& builder, const std::vector<SurfacePoint>& points,
                    double rho, std::uint64_t paths, double relative_error) {
  const Scene scene = with_materials(builder.build(), Spectrum{rho}, Spectrum{100}, Spectrum{100});
  for (const ReferencePoint& found : traced(scene, points, paths))
    expect_found(found, Spectrum{100 / (1 - rho)}, relative_error);
}

TEST(PathTracer, FurnaceCubeIsEven) {
  SceneBuilder s;
  s.box("cube", {0, 0, 0}, {3, 3, 3}, true);
  const std::vector<SurfacePoint> points{
      {{1, 1, 0}, {0, 0, 1}}, {{0, 1.5, .001}, {1, 0, 0}}, {{2, 2.99, 3}, {0, 0, -1}}};
  // The number of a path's bounces scatters like ρ/(1-ρ)²: over 2048 paths 2%.
  expect_furnace(s, points, 0.9, 2048, 0.03);
  // No path is cut off: they are a thousand bounces long. 512 of them: 4.4%.
  expect_furnace(s, points, 0.999, 512, 0.09);
}

TEST(PathTracer, FurnaceOfTwoRoomsIsEven) {
  const std::vector<SurfacePoint> points{
      {{1, 1, 0}, {0, 0, 1}}, {{6, 2, 3}, {0, 0, -1}}, {{4.1, 1, 1}, {0, 1, 0}}};
  expect_furnace(two_rooms_with_doorway(), points, 0.9, 2048, 0.03);
}

// A cube of 4 m with a square lamp of 1 m flush in its ceiling. [CIE 171:2006, in the manner
// of 5.8]
SceneBuilder cube_with_lamp() {
  SceneBuilder s;
  s.quad("floor", {0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  s.quad("west", {0, 0, 0}, {0, 4, 0}, {0, 0, 4}).quad("east", {4, 0, 0}, {0, 0, 4}, {0, 4, 0});
  s.quad("south", {0, 0, 0}, {0, 0, 4}, {4, 0, 0}).quad("north", {0, 4, 0}, {4, 0, 0}, {0, 0, 4});
  const auto down = [&](double x, double y, double dx, double dy, bool emits) {
    s.quad("ceiling", {x, y, 4}, {0, dy, 0}, {dx, 0, 0}, kFront, emits);
  };
  down(0, 0, 4, 1.5, false), down(0, 2.5, 4, 1.5, false);
  down(0, 1.5, 1.5, 1, false), down(2.5, 1.5, 1.5, 1, false);
  down(1.5, 1.5, 1, 1, true);
  return s;
}

TEST(PathTracer, InterreflectionInACubeKeepsItsEnergy) {
  constexpr double kFlux = 10000;
  for (const double rho : {0.1, 0.5, 0.95}) {
    const Scene scene = with_materials(cube_with_lamp().build(), Spectrum{rho}, Spectrum{kFlux});
    PathTracer tracer(scene, 3);
    const std::vector<SurfacePoint> points = draw_lit_points(tracer, 1000, 3);
    ASSERT_EQ(points.size(), 1000u);
    double sum = 0, squares = 0;
    for (const ReferencePoint& p : trace_reference(tracer, points, {.paths = 64}, {}).points)
      sum += p.irradiance.x, squares += p.irradiance.x * p.irradiance.x;
    const double n = double(points.size()), mean = sum / n;
    const double error = std::sqrt((squares / n - mean * mean) / n);
    // All that is sent is absorbed: the area mean of E is Φ/(96(1-ρ)).
    EXPECT_NEAR(mean, kFlux / (96 * (1 - rho)), kSigmas * error) << "rho " << rho;
    EXPECT_LT(error, 0.04 * mean);
  }
}

TEST(PathTracer, OneSidedLampIsDarkFromBehindAndTwoSidedIsNot) {
  const Polygon lamp{{-.5, -.5, 1}, {.5, -.5, 1}, {.5, .5, 1}, {-.5, .5, 1}};  // faces up
  const SurfacePoint below{{.2, .1, 0}, {0, 0, 1}};
  const Polygon seen_from_below(lamp.rbegin(), lamp.rend());
  const double expected = 100 * point_to_polygon(below.x, below.normal, seen_from_below);
  for (const Sides sides : {kFront, kBack, kBothSides}) {
    SceneBuilder s;
    s.quad("floor", {-2, -2, 0}, {4, 0, 0}, {0, 4, 0}).polygon("lamp", lamp, sides, true);
    const Scene scene = with_materials(s.build(), Spectrum{0}, Spectrum{100});
    expect_found(traced(scene, {below}, 1024)[0], Spectrum{sides == kFront ? 0 : expected}, 0.01);
  }
}

// A lamp that shines up on a plate whose front faces up too; E beside the lamp, whose direct light
// passes by.
Scene plate_over_lamp(Sides plate_sides, bool covered) {
  SceneBuilder s;
  s.quad("lamp", {-.5, -.5, 0}, {1, 0, 0}, {0, 1, 0}, kFront, true);
  s.quad("plate", {-1, -1, 1}, {2, 0, 0}, {0, 2, 0}, plate_sides);
  // The same place once more, its front down.
  if (covered) s.quad("lining", {-1, -1, 1}, {0, 2, 0}, {2, 0, 0}, kFront);
  return with_materials(s.build(), Spectrum{.8}, Spectrum{100});
}

TEST(PathTracer, BackOfAOneSidedPlateIsBlackAndACoplanarLiningStandsIn) {
  const std::vector<SurfacePoint> beside{{{.8, 0, 0}, {0, 0, 1}}};
  EXPECT_EQ(traced(plate_over_lamp(kFront, false), beside, 1024)[0].irradiance, Spectrum{0});
  const ReferencePoint both = traced(plate_over_lamp(kBothSides, false), beside, 8192, 1)[0];
  const ReferencePoint lined = traced(plate_over_lamp(kFront, true), beside, 8192, 2)[0];
  EXPECT_GT(both.irradiance.x, 10 * both.standard_error.x);
  EXPECT_NEAR(both.irradiance.x, lined.irradiance.x,
              kSigmas * std::hypot(both.standard_error.x, lined.standard_error.x));
}

// Nine lamps of many sizes over a black floor, none of which hides another: what each point gets is
// the sum of closed forms.
struct ManyLamps {
  Scene scene;
  std::vector<SurfacePoint> points;
  std::vector<double> expected;
};

ManyLamps many_lamps(int side) {
  ManyLamps m;
  SceneBuilder s;
  s.quad("floor", {0, 0, 0}, {9, 0, 0}, {0, 9, 0});
  std::vector<Polygon> lamps;
  for (int i = 0; i < 9; ++i) {
    const double x = 1.5 + 3 * (i % 3), y = 1.5 + 3 * (i / 3), z = 0.5, h = 0.05 * (i + 1);
    lamps.push_back({{x - h, y - h, z}, {x - h, y + h, z}, {x + h, y + h, z}, {x + h, y - h, z}});
    s.polygon("lamp", lamps.back(), kFront, true);
  }
  m.scene = with_materials(s.build(), Spectrum{0}, Spectrum{100});
  for (int i = 0; i < side * side; ++i) {
    const Vec3 x{9 * (i % side + .5) / side, 9 * (i / side + .5) / side, 0};
    double sum = 0;
    for (const Polygon& lamp : lamps) sum += 100 * point_to_polygon(x, {0, 0, 1}, lamp);
    m.points.push_back({x, {0, 0, 1}});
    m.expected.push_back(sum);
  }
  return m;
}

TEST(PathTracer, StandardErrorsAreHonest) {
  const ManyLamps m = many_lamps(40);
  const auto found = traced(m.scene, m.points, 1024);
  double z = 0, z2 = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double d = (found[i].irradiance.x - m.expected[i]) / found[i].standard_error.x;
    z += d, z2 += d * d;
  }
  // Student's t of 31 degrees of freedom: mean 0, variance 31/29, and its square's variance
  // 2(31/29)²(30/27): over n points the mean of squares scatters by the root of that over n.
  const double n = double(found.size()), variance = 31.0 / 29;
  EXPECT_NEAR(z / n, 0, kSigmas * std::sqrt(variance / n));
  EXPECT_NEAR(z2 / n, variance, kSigmas * variance * std::sqrt(2 * 30.0 / 27 / n));
}

TEST(PathTracer, BitsAreTheSameForAnyNumberOfThreads) {
  const Scene scene = with_materials(two_rooms_with_doorway().build(), Spectrum{.5}, Spectrum{100});
  PathTracer first(scene, 5), second(scene, 5);
  const ReferenceOptions options{.noise = 0.05};
  const auto on = [&](int threads, PathTracer& tracer) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    tbb::task_arena arena(threads);
    return arena.execute([&] {
      const std::vector<SurfacePoint> points = draw_lit_points(tracer, 50, 9);
      return trace_reference(tracer, points, options, {});
    });
  };
  const ReferenceResult one = on(1, first), four = on(4, second);
  ASSERT_EQ(one.points.size(), 50u);
  ASSERT_EQ(four.points.size(), 50u);
  EXPECT_EQ(one.rays, four.rays);
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_EQ(one.points[i].irradiance, four.points[i].irradiance);
    EXPECT_EQ(one.points[i].standard_error, four.points[i].standard_error);
  }
}

TEST(Reference, GoesOnUntilEveryPointIsBelowTheNoise) {
  const ManyLamps m = many_lamps(6);
  PathTracer tracer(m.scene, 2);
  const ReferenceResult r = trace_reference(tracer, m.points, {.noise = 0.01}, {});
  double mean = 0;
  for (const ReferencePoint& p : r.points)
    mean += luminance(p.irradiance) / double(r.points.size());
  std::size_t near = 0;
  for (const ReferencePoint& p : r.points) {
    const double share = luminance(p.standard_error) / std::max(luminance(p.irradiance), mean);
    EXPECT_LE(share, 0.01);
    near += share > 0.005;
  }
  EXPECT_GT(near, 0u);  // nor does it go on for nothing
  EXPECT_LE(r.noise, 0.01);
  EXPECT_GT(r.noise, 0.002);
}

TEST(Reference, DrawsPointsByAreaWhereLightReaches) {
  // A lit cube of 2 m, and a dark one of the same size beside it.
  SceneBuilder s;
  s.box("lit", {0, 0, 0}, {2, 2, 2}, true).box("dark", {3, 0, 0}, {5, 2, 2}, true);
  s.lamp("lamp", {1, 1, 1.5}, 0.2);
  const Scene scene = s.build();
  const PathTracer tracer(scene, 1);
  constexpr int kPoints = 300;
  const std::vector<SurfacePoint> points = draw_lit_points(tracer, kPoints, 4);
  ASSERT_EQ(points.size(), std::size_t{kPoints});
  int on_floor = 0;
  for (const SurfacePoint& p : points) {
    EXPECT_LE(p.x.x, 2);
    on_floor += p.x.z == 0;
  }
  // The floor has 4 of 24.04 m²; a binomial count.
  const double share = 4 / 24.04;
  EXPECT_NEAR(on_floor, kPoints * share, kSigmas * std::sqrt(kPoints * share * (1 - share)));
}

}  // namespace
}  // namespace atrium
