// A lamp-lit room with furniture where every surface reflects the same share ρ of the light.
// Nothing leaves it: what its surfaces absorb is Φ, the lamps' flux, however often the light goes
// round. A furnace would not tell: uniform light passes as soon as rows sum to 1.
// [facts/radiosity.md]
#include <gtest/gtest.h>

#include "scheduler/solve.h"
#include "test/agree/run.h"
#include "test/scheduler/solved_store.h"

namespace atrium::testing {
namespace {

constexpr double kError = 0.02, kResidual = 1e-6;
// What links from coarse elements leave out of their detail is brought along: without, rooms lose
// .9% and Cornell 1.4% of Φ.
constexpr double kLost = 0.005;

GeneratedModel painted(const GenerateOptions& options, double reflectance) {
  Result<GeneratedModel> model = generate(options);
  EXPECT_TRUE(model.ok());
  for (Paint& p : model->paints) p.reflectance = Spectrum{reflectance};
  return std::move(model).value();
}

SolveSummary solved_white(const GenerateOptions& options, double reflectance) {
  Bench bench(painted(options, reflectance));
  SolveOptions asked = bench.options();
  asked.error = kError;
  asked.residual = kResidual;
  Result<SolveSummary> summary = solve(asked, {}, {});
  EXPECT_TRUE(summary.ok()) << summary.status().message();
  return summary.ok() ? std::move(summary).value() : SolveSummary();
}

// Plain Gauss-Seidel takes some 60 gathers at ρ = .9, and over 300 beyond. [facts/radiosity.md]
void expect_all_light_found(const GenerateOptions& options, double reflectance,
                            double most_gathers, double lost = kLost) {
  const SolveSummary s = solved_white(options, reflectance);
  EXPECT_LE(s.residual, kResidual);
  EXPECT_LE(s.iterations, most_gathers);
  EXPECT_NEAR(s.flux_absorbed, s.flux_emitted, lost * s.flux_emitted);
}

const GenerateOptions kOneRoom{.kind = "rooms", .grid = 1};

TEST(WhiteRoom, GreyWallsTakeAsFewGathersAsWhiteOnes) { expect_all_light_found(kOneRoom, .9, 12); }
TEST(WhiteRoom, NearlyAllIsReflected) { expect_all_light_found(kOneRoom, .999, 11); }
TEST(WhiteRoom, LightGoesRoundAHundredThousandTimes) {
  expect_all_light_found(kOneRoom, .99999, 11);
}
TEST(WhiteRoom, BoxesStandInTheLight) { expect_all_light_found({.kind = "cornell"}, .99999, 12); }
TEST(WhiteRoom, RoomsOpenIntoRooms) {
  expect_all_light_found({.kind = "rooms", .grid = 2}, .99999, 15);
}
// Behind its radiators light goes to and fro by waves that no coarse unit is small enough for.
TEST(WhiteRoom, AnOfficeTakesLongerButSettles) {
  constexpr double kLostBehindRadiators = 0.02;
  expect_all_light_found({.kind = "office"}, .999, 50, kLostBehindRadiators);
}

// The boxes are closed, or stand closed on the floor.
TEST(WhiteRoom, InsideItsBoxesIsNoLight) {
  Bench bench(painted(kOneRoom, .98));
  SolvedStore run(solved(bench), std::size_t{16} << 20);
  std::size_t inert = 0;
  run.change([&](PatchTree& tree) {
    inert += tree.head.inert;
    for (const double e : tree.e) EXPECT_TRUE(!tree.head.inert || e == 0);
  });
  EXPECT_GT(inert, 5u);
}

}  // namespace
}  // namespace atrium::testing
