// The furnace: in any closed scene whose surfaces all have reflectance ρ and exitance M, every
// point's radiosity is M/(1-ρ), whatever the shape and whatever stands inside.
#include <gtest/gtest.h>

#include "test/physics/rooms.h"

namespace atrium::testing {
namespace {

struct Case {
  std::string shape;
  double rho;
  double tolerance;  // relative
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.shape << ", rho " << c.rho; }

class Furnace : public ::testing::TestWithParam<Case> {};

TEST_P(Furnace, EveryPointHasTheSameRadiosity) {
  const Case& c = GetParam();
  constexpr double kExitance = 100;
  const GeneratedModel model =
      generated({.kind = "furnace", .rho = c.rho, .exitance = kExitance, .shape = c.shape});
  Bench bench(model);
  SolvedRun run(bench.options());
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run.summary().exit_code, 0);
  const double expected = kExitance / (1 - c.rho);
  const std::vector<Probe> probes = probes_on(model, 8);
  for (const Probe& p : probes) {
    const std::optional<SurfaceSample> s = run.at(p);
    ASSERT_TRUE(s.has_value());
    for (int channel = 0; channel < 3; ++channel)
      EXPECT_NEAR(s->radiosity[channel], expected, c.tolerance * expected);
  }
  // What is sent out of a closed scene arrives in it.
  const SolveSummary& sum = run.summary();
  EXPECT_NEAR(sum.flux_absorbed, sum.flux_emitted, c.tolerance * sum.flux_emitted);
  EXPECT_EQ(sum.flux_escaped, 0);
}

// What the solve leaves undone is a fiftieth of the error asked for, 2%; times 1/(1-ρ) at most.
INSTANTIATE_TEST_SUITE_P(Shapes, Furnace,
                         ::testing::Values(Case{"cube", .5, .001}, Case{"l-room", .5, .001},
                                           Case{"two-rooms", .5, .001}, Case{"grid3x3", .8, .005}),
                         [](const ::testing::TestParamInfo<Case>& c) {
                           std::string name = c.param.shape;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace atrium::testing
