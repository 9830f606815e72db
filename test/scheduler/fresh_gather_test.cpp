// Light gathered afresh from a stored solution, against closed forms and against its own scatter.
#include "scheduler/fresh_gather.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engine/squared.h"
#include "solver/form_factor.h"
#include "test/physics/rooms.h"
#include "test/scheduler/solved_store.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kArena = std::size_t{32} << 20;
const Vec3 kRoom{4, 3, 2.7};
constexpr double kLampSide = 0.6, kLuminance = 1000;  // m; cd/m²

// In a furnace every ray brings M/(1-ρ), so that a handful do, and they scatter by nothing.
TEST(FreshGather, FurnaceIsExactWithAFewRays) {
  constexpr double kExitance = 100, kRho = 0.5, kExpected = kExitance / (1 - kRho);
  for (const char* shape : {"cube", "l-room", "two-rooms"}) {
    SCOPED_TRACE(shape);
    Bench bench(generated({.kind = "furnace", .rho = kRho, .exitance = kExitance, .shape = shape}));
    SolvedStore run(solved(bench), kArena);
    run.change([&](PatchTree& tree) { set_even(tree, kExpected); });
    std::vector<GatherPoint> points;
    for (std::uint32_t p = 0; p < run.model().patches.size(); ++p)
      if (!run.model().patches[p].inert) points.push_back(run.point_on(PatchId(p), 0.9));
    for (const FreshIrradiance& e : run.gather(points, {.directions = 24, .replicates = 3}))
      for (int c = 0; c < kChannels; ++c) {
        EXPECT_NEAR(e.mean[c], kExpected, 1e-9 * kExpected);
        EXPECT_NEAR(e.standard_error[c], 0, 1e-9 * kExpected);
        EXPECT_EQ(e.escaped, 0);
        EXPECT_EQ(e.black, 0);
      }
  }
}

// A rectangle a × b parallel to a point's plane at distance c, one corner above it; the form factor
// is the sum of two arcs. [Siegel & Howell, configuration factor 10]
double corner_factor(double a, double b, double c) {
  const double x = a / c, y = b / c;
  const double u = std::sqrt(1 + x * x), v = std::sqrt(1 + y * y);
  return (x / u * std::atan(y / u) + y / v * std::atan(x / v)) / (2 * kPi);
}

Builder black_room_with_lamp() {
  Builder b("a black room");
  const PaintId black = b.paint("black", 0);
  const PaintId lamp = b.paint("lamp", 0, kLuminance);
  b.walls_and_floor(black, Vec3{0}, kRoom);
  b.ceiling_with_lamp(black, lamp, Vec3{0}, kRoom, kLampSide);
  return b;
}

const Vec3 kUnderTheLamp{kRoom.x / 2, kRoom.y / 2, 0}, kUp{0, 0, 1};
double under_the_lamp() {
  return kPi * kLuminance * 4 * corner_factor(kLampSide / 2, kLampSide / 2, kRoom.z);
}

// A lamp that is wholly seen brings its closed form: no ray adds noise.
TEST(FreshGather, UnderASquareLamp) {
  Bench bench(black_room_with_lamp().take());
  SolvedStore run(solved(bench), kArena);
  const GatherPoint point = run.point_at(kUnderTheLamp, kUp);
  const FreshIrradiance e = run.gather({&point, 1}, {.directions = 64}).at(0);
  EXPECT_NEAR(luminance(e.mean), under_the_lamp(), 1e-6 * under_the_lamp());
  EXPECT_NEAR(luminance(e.standard_error), 0, 1e-9 * under_the_lamp());
}

// A black screen half way up ends straight above the point, so that it hides half of the lamp.
TEST(FreshGather, UnderALampHalfHidden) {
  constexpr double kMost = 0.05;  // of E: what 512 rays may be off by
  Builder b = black_room_with_lamp();
  b.rectangle("screen", 0, {0, 0, kRoom.z / 2}, {kRoom.x / 2, 0, 0}, {0, kRoom.y, 0});
  Bench bench(b.take());
  SolvedStore run(solved(bench), kArena);
  // On the floor's side that the screen covers and on the other alike: a hair beside its edge.
  const GatherPoint point = run.point_at(kUnderTheLamp + Vec3{1e-4, 0, 0}, kUp);
  const FreshIrradiance e = run.gather({&point, 1}, {.directions = 512, .replicates = 8}).at(0);
  const double expected = under_the_lamp() / 2, error = luminance(e.standard_error);
  EXPECT_GT(error, 0);
  EXPECT_LT(error, kMost * expected);
  EXPECT_NEAR(luminance(e.mean), expected, 4 * error + 1e-3 * expected);
}

// Far more lamps than rays: which get one is left to chance, and that evens out. A screen half way
// up ends straight above the point: it hides a third of the lamps, and none of the others.
TEST(FreshGather, ManyLampsAreChosenByChanceWithoutBias) {
  constexpr int kAlong = 20, kAcross = 15, kSeeds = 200;
  constexpr double kSide = 0.1, kStep = 0.2;      // m
  constexpr double kEdge = 7 * kStep;             // of the screen, between two rows of lamps
  constexpr double kCentres = squared(0.02);      // the kernel at a far lamp's centre errs by less
  constexpr double kChance = 1e-5, kMost = 1e-2;  // of E: bounds of the mean's noise
  const Vec3 x{kEdge, kRoom.y / 2, 0};
  Builder b("a black floor under many lamps");
  const PaintId black = b.paint("black", 0);
  b.rectangle("floor", black, Vec3{0}, {kRoom.x, 0, 0}, {0, kRoom.y, 0});
  b.rectangle("screen", black, {0, 0, kRoom.z / 2}, {kEdge, 0, 0}, {0, kRoom.y, 0});
  const std::array lamps{b.paint("dim", 0, kLuminance), b.paint("lamp", 0, 2 * kLuminance),
                         b.paint("bright", 0, 3 * kLuminance)};
  double expected = 0;
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double luminance = kLuminance * (1 + j % 3);
      const PaintId lamp = lamps[std::size_t(j % 3)];
      const Vec3 corner{kStep * i + kSide / 2, kStep * j + kSide / 2, kRoom.z};
      const Vec3 u{0, kSide, 0}, v{kSide, 0, 0};
      b.rectangle("lamp", lamp, corner, u, v);
      const Polygon outline{corner, corner + u, corner + u + v, corner + v};
      if (corner.x > kEdge) expected += kPi * luminance * point_to_polygon(x, kUp, outline);
    }
  Bench bench(b.take());
  SolvedStore run(solved(bench), kArena);
  const GatherPoint point = run.point_at(x, kUp);
  double sum = 0, squares = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto e = run.gather({&point, 1}, {.directions = 32, .replicates = 2, .seed = seed});
    sum += luminance(e.at(0).mean);
    squares += squared(luminance(e.at(0).mean));
  }
  const double mean = sum / kSeeds;
  const double error = std::sqrt((squares / kSeeds - mean * mean) / (kSeeds - 1));
  EXPECT_GT(error, kChance * expected);
  EXPECT_LT(error, kMost * expected);
  EXPECT_NEAR(mean, expected, 4 * error + kCentres * expected);
}

// A lamp that reaches from below a point's horizon to above it: a ray or two bring all of what is
// above, whatever their number.
TEST(FreshGather, ALampAcrossTheHorizonIsExactWithARay) {
  Builder b("a shelf beside a tall lamp");
  const PaintId black = b.paint("black", 0), lamp = b.paint("lamp", 0, kLuminance);
  b.rectangle("shelf", black, {0, 0, 1}, {0.9, 0, 0}, {0, 3, 0});
  b.rectangle("lamp", lamp, {1, 1, 0}, {0, 0, 2}, {0, 1, 0});
  Bench bench(b.take());
  SolvedStore run(solved(bench), kArena);
  const Vec3 x{0.3, 1.4, 1};
  const Polygon above{{1, 1, 1}, {1, 1, 2}, {1, 2, 2}, {1, 2, 1}};
  const double expected = kPi * kLuminance * point_to_polygon(x, kUp, above);
  const GatherPoint point = run.point_at(x, kUp);
  for (std::uint64_t seed = 1; seed <= 32; ++seed) {
    const auto e = run.gather({&point, 1}, {.directions = 1, .replicates = 1, .seed = seed});
    EXPECT_NEAR(luminance(e.at(0).mean), expected, 1e-6 * expected);
  }
}

// What 64 gathers of other seeds scatter by is what each says of itself.
TEST(FreshGather, StandardErrorIsHonest) {
  constexpr int kSeeds = 64;
  Bench bench(generated({.kind = "cornell"}));
  SolvedStore run(solved(bench), kArena);
  std::vector<GatherPoint> points;
  for (std::uint32_t p = 0; p < run.model().patches.size(); ++p)
    if (!run.model().patches[p].inert) points.push_back(run.point_on(PatchId(p), 0.37));
  std::vector<double> sum(points.size()), squares(points.size()), said(points.size());
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const auto e = run.gather(points, {.directions = 64, .replicates = 8, .seed = seed});
    for (std::size_t i = 0; i < e.size(); ++i) {
      const double x = luminance(e[i].mean), s = luminance(e[i].standard_error);
      sum[i] += x;
      squares[i] += x * x;
      said[i] += s * s / kSeeds;
    }
  }
  double scatter = 0, all_said = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double mean = sum[i] / kSeeds;
    scatter += (squares[i] - kSeeds * mean * mean) / (kSeeds - 1) / (mean * mean);
    all_said += said[i] / (mean * mean);
  }
  // Some 30 points × 63 degrees of freedom: a few percent, with room for unlike ones.
  EXPECT_GT(all_said, 0);
  EXPECT_NEAR(scatter / all_said, 1, 0.2);
}

// A lone lamp over a floor: what misses the lamp and its surroundings is counted as escaped.
TEST(FreshGather, RaysThatLeaveTheSceneAreCounted) {
  Builder b("a floor and a lamp");
  const PaintId grey = b.paint("grey", 0.5), lamp = b.paint("lamp", 0, kLuminance);
  b.rectangle("floor", grey, Vec3{0}, {kRoom.x, 0, 0}, {0, kRoom.y, 0});
  b.rectangle("lamp", lamp, {1.7, 1.2, kRoom.z}, {0, kLampSide, 0}, {kLampSide, 0, 0});
  Bench bench(b.take());
  SolvedStore run(solved(bench), kArena);
  const GatherPoint point = run.point_at({2, 1.5, 0}, kUp);
  const FreshIrradiance e = run.gather({&point, 1}, {.directions = 4096}).at(0);
  const double form_factor = 4 * corner_factor(kLampSide / 2, kLampSide / 2, kRoom.z);
  // Even sequences miss a share by less than chance would, 3 √(F/n).
  EXPECT_NEAR(e.escaped, 1 - form_factor, 3 * std::sqrt(form_factor / 4096));
  EXPECT_NEAR(luminance(e.mean), under_the_lamp(), 1e-6 * under_the_lamp());
}

}  // namespace
}  // namespace atrium::testing
