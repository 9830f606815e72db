// A lamp-lit room with furniture where every surface reflects the same share ρ of the light.
// Nothing leaves it: what its surfaces absorb is Φ, the lamps' flux, however often the light goes
// round. A furnace would not tell: uniform light passes as soon as rows sum to 1.
// [facts/radiosity.md]
#include <gtest/gtest.h>

#include "scheduler/solve.h"
#include "test/agree/run.h"

namespace atrium::testing {
namespace {

constexpr double kError = 0.02, kResidual = 1e-6;
// What links from coarse elements leave out of their detail is brought along: without, rooms lose
// .9% and Cornell 1.4% of Φ.
constexpr double kLost = 0.005;

SolveSummary solved_white(const std::string& kind, double reflectance) {
  GenerateOptions options{.kind = kind};
  if (kind == "rooms") options.grid = 1;
  Result<GeneratedModel> model = generate(options);
  EXPECT_TRUE(model.ok());
  for (Paint& p : model->paints) p.reflectance = Spectrum{reflectance};
  Bench bench(*model);
  SolveOptions asked = bench.options();
  asked.error = kError;
  asked.residual = kResidual;
  asked.iterations = 30;
  Result<SolveSummary> summary = solve(asked, {}, {});
  EXPECT_TRUE(summary.ok()) << summary.status().message();
  return summary.ok() ? std::move(summary).value() : SolveSummary();
}

// Plain Gauss-Seidel takes some 60 gathers at ρ = .9, and over 300 beyond. [facts/radiosity.md]
void expect_all_light_found(const std::string& kind, double reflectance, double most_gathers) {
  const SolveSummary s = solved_white(kind, reflectance);
  EXPECT_LE(s.residual, kResidual);
  EXPECT_LE(s.iterations, most_gathers);
  EXPECT_NEAR(s.flux_absorbed, s.flux_emitted, kLost * s.flux_emitted);
}

TEST(WhiteRoom, GreyWallsTakeAsFewGathersAsWhiteOnes) { expect_all_light_found("rooms", .9, 12); }
TEST(WhiteRoom, NearlyAllIsReflected) { expect_all_light_found("rooms", .999, 11); }
TEST(WhiteRoom, LightGoesRoundAHundredThousandTimes) {
  expect_all_light_found("rooms", .99999, 11);
}
TEST(WhiteRoom, BoxesStandInTheLight) { expect_all_light_found("cornell", .99999, 12); }

}  // namespace
}  // namespace atrium::testing
