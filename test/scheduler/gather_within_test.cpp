// Light between faces of one cluster: a panel shines on a plate, and another plate next to it that
// sees no panel shines by the first alone.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "scheduler/solve.h"
#include "solver/form_factor.h"
#include "test/agree/run.h"

namespace atrium::testing {
namespace {

constexpr double kWhite = 0.99;
constexpr double kExitance = 1000 * std::numbers::pi;  // lm/m², of the panel
constexpr double kRoom = 5;                            // m, half its edge
constexpr double kGap = 0.2;                           // m

void add_face(GeneratedModel& m, PaintId paint, PolygonView corners) {
  m.faces.push_back({paint, std::uint32_t(m.vertices.size()), std::uint32_t(corners.size())});
  m.vertices.insert(m.vertices.end(), corners.begin(), corners.end());
}

const Polygon kPanel{{1, 0, kGap}, {1, 1, kGap}, {1.5, 1, kGap}, {1.5, 0, kGap}};
const Polygon kUpper{{0, 0, kGap}, {0, 1, kGap}, {1, 1, kGap}, {1, 0, kGap}};

// The mean over a unit square of f(x, y), by the midpoints of cells.
template <class F>
double mean_over_square(const F& f) {
  constexpr int kCells = 40;
  double sum = 0;
  for (int i = 0; i < kCells; ++i)
    for (int j = 0; j < kCells; ++j) sum += f((i + 0.5) / kCells, (j + 0.5) / kCells);
  return sum / (kCells * kCells);
}

// The inside of a black box, as one object; in the middle of it, as another, a plate of a metre
// and, kGap above it, another one that faces it; beside that one, facing down, a black panel that
// shines.
GeneratedModel plates() {
  GeneratedModel m;
  m.paints = {{"white", Spectrum{kWhite}, Spectrum{0}},
              {"panel", Spectrum{0}, Spectrum{1000}},
              {"black", Spectrum{0}, Spectrum{0}}};
  const double l = -kRoom, h = kRoom;
  add_face(m, 2, Polygon{{l, l, l}, {h, l, l}, {h, h, l}, {l, h, l}});
  add_face(m, 2, Polygon{{l, l, h}, {l, h, h}, {h, h, h}, {h, l, h}});
  add_face(m, 2, Polygon{{l, l, l}, {l, l, h}, {h, l, h}, {h, l, l}});
  add_face(m, 2, Polygon{{l, h, l}, {h, h, l}, {h, h, h}, {l, h, h}});
  add_face(m, 2, Polygon{{l, l, l}, {l, h, l}, {l, h, h}, {l, l, h}});
  add_face(m, 2, Polygon{{h, l, l}, {h, l, h}, {h, h, h}, {h, h, l}});
  add_face(m, 0, Polygon{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  add_face(m, 0, kUpper);
  add_face(m, 1, kPanel);
  m.groups = {{"room", 0, 6}, {"plates", 6, 3}};
  return m;
}

// The panel shines on the lower plate alone, and that on the upper one, which is gathered to after
// it: lit in the same gather, by what the lower one got by then. A first gather knows its sources
// as one linear function a patch, of which the plates' symmetry leaves the mean.
TEST(GatherWithin, APlateThatSeesNoLampIsLitInTheFirstGather) {
  constexpr double kCoarse = 0.05;  // first links are made for sixteen times the error asked
  const auto mean_form_factor = [](PolygonView to) {
    return mean_over_square([&](double x, double y) {
      return point_to_polygon({x, y, 0}, {0, 0, 1}, to);
    });
  };
  const double once_reflected =
      kWhite * kExitance * mean_form_factor(kPanel) * mean_form_factor(kUpper);
  Bench bench(plates());
  SolveOptions options = bench.options();
  options.iterations = 1;
  SolvedRun run(options);
  ASSERT_TRUE(run.ok());
  ASSERT_EQ(run.summary().clusters, 2u);
  const double found = mean_over_square([&](double x, double y) {
    const std::optional<SurfaceSample> sample = run.at({{x, y, kGap}, {0, 0, -1}});
    EXPECT_TRUE(sample);
    return sample ? luminance(sample->irradiance) : 0;
  });
  EXPECT_NEAR(found, once_reflected, kCoarse * once_reflected);
}

// What goes to and fro between the plates by waves of k = π / 1 m, the longest that the coarse
// system's units do not hold, falls from one plate to the other to μ = ρ kh K₁(kh) at the most, h
// their distance: the kernel's transform, of plates without an end. That is .77; power iteration
// over these plates found .54. Patch by patch, ω times over, the spectral radius λ of a sweep
// satisfies (λ + ω - 1)² = λ ω² μ² [Young 1954], so it is ω - 1 where ω²μ² ≤ 4 (ω - 1): with
// ω = 1.25 and μ ≤ .8 a quarter, ten sweeps for a millionth. As many again for the links of three
// levels, each unlike those before. By what patches held before the gather it would be
// 1 - ω - ωμ = -.93, light that turns back and forth for some 190 sweeps.
TEST(GatherWithin, LightBetweenWhitePlatesOfOneClusterSettlesBySuccessiveOverRelaxation) {
  constexpr double kOver = 1.25, kResidual = 1e-6;
  const double kh = std::numbers::pi * kGap, mu = kWhite * kh * std::cyl_bessel_k(1, kh);
  ASSERT_LE(std::pow(kOver * mu, 2), 4 * (kOver - 1));
  const double sweeps = std::log(kResidual) / std::log(kOver - 1);
  Bench bench(plates());
  SolveOptions options = bench.options();
  options.residual = kResidual;
  options.iterations = std::uint64_t(2 * sweeps);
  const Result<SolveSummary> s = solve(options, {}, {});
  ASSERT_TRUE(s.ok()) << s.status().message();
  ASSERT_EQ(s->clusters, 2u);
  EXPECT_LE(s->residual, kResidual) << "after " << s->iterations;
}

}  // namespace
}  // namespace atrium::testing
