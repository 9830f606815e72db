// The estimate of a solution's error, on solutions whose error is known since it was put there, and
// on a solved scene by any number of threads and in any arena.
#include "scheduler/error_estimate.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "engine/squared.h"
#include "solver/element_tree.h"
#include "test/physics/rooms.h"
#include "test/scheduler/solved_store.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kArena = std::size_t{64} << 20;
constexpr double kExitance = 100;
constexpr EstimateSettings kFew{.points = 512, .directions = 64};

ErrorEstimate estimate(SolvedStore& run, const EstimateSettings& settings) {
  const Result<BrightSources> bright = BrightSources::find(run.model(), run.store());
  EXPECT_TRUE(bright.ok());
  const Result<ErrorEstimate> e =
      estimate_error(run.model(), run.store(), run.fresh(), *bright, settings);
  EXPECT_TRUE(e.ok()) << e.status().message();
  return e.ok() ? *e : ErrorEstimate{};
}

// A closed cube where all surfaces reflect ρ and emit M: E is M/(1-ρ) everywhere.
struct Furnace {
  explicit Furnace(double reflectance)
      : rho(reflectance),
        bench(generated({.kind = "furnace", .rho = rho, .exitance = kExitance, .shape = "cube"})),
        run(solved(bench), kArena) {}
  double truth() const { return kExitance / (1 - rho); }
  double rho;
  Bench bench;
  SolvedStore run;
};

TEST(ErrorEstimate, AnExactSolutionHasNone) {
  Furnace f(0.5);
  f.run.change([&](PatchTree& tree) { set_even(tree, f.truth()); });
  const ErrorEstimate e = estimate(f.run, kFew);
  EXPECT_LT(e.error, 1e-6);
  EXPECT_NEAR(e.closure, 1, 1e-9);
  EXPECT_EQ(e.points, 512u);
}

// E a tenth too large. A fresh gather brings M + ρ 1.1 E, which is off by a tenth of ρ E, and shows
// 1-ρ tenths as residual; the error is a tenth whatever ρ is. Of the flux Φ = M A, fresh gathers
// absorb (1-ρ)(E + .1 ρ E) A = Φ (1 + .1 ρ).
TEST(ErrorEstimate, TooBrightByATenthAtAnyReflectance) {
  for (const double rho : {0.5, 0.9, 0.98}) {
    SCOPED_TRACE(rho);
    Furnace f(rho);
    f.run.change([&](PatchTree& tree) { set_even(tree, 1.1 * f.truth()); });
    const ErrorEstimate e = estimate(f.run, kFew);
    EXPECT_NEAR(e.error, 0.1, 1e-6);
    EXPECT_NEAR(e.local, 0.1 * (1 - rho), 1e-6);
    EXPECT_NEAR(e.closure, 1 + 0.1 * rho, 1e-6);
    EXPECT_LE(e.low, e.error);
    EXPECT_GE(e.high, e.error);
  }
}

// Nothing solved yet: E = 0, which is wrong by all there is, though the residual is M alone.
TEST(ErrorEstimate, NothingSolvedIsWrongByAll) {
  Furnace f(0.5);
  f.run.change([&](PatchTree& tree) { set_even(tree, 0); });
  EXPECT_NEAR(estimate(f.run, kFew).error, 1, 1e-6);
}

// The floor under a box stands in the dark, whatever the solution has there: it is no error, and
// none that others inherit. All else is a furnace.
TEST(ErrorEstimate, ACoveredFloorIsNotAsked) {
  constexpr double kRho = 0.5, kTruth = kExitance / (1 - kRho);
  const Vec3 room{4, 3, 2.7};
  Builder b("a box in a furnace");
  const PaintId glow = b.paint("glow", kRho, kExitance / kPi);
  b.walls_and_floor(glow, Vec3{0}, room);
  b.ceiling(glow, Vec3{0}, room);
  b.standing_box("box", glow, {1, 1, 0}, {2, 2, 1});
  Bench bench(b.take());
  SolvedStore run(solved(bench), kArena);
  run.change([&](PatchTree& tree) { set_even(tree, kTruth); });
  const ErrorEstimate e = estimate(run, kFew);
  EXPECT_LT(e.error, 1e-6);
  EXPECT_NEAR(e.closure, 1, 1e-6);
}

void split_all(PatchTree& tree, int times) {
  for (int t = 0; t < times; ++t) {
    const auto count = static_cast<std::int32_t>(tree.elements.size());
    for (std::int32_t i = 0; i < count; ++i)
      if (tree.elements[static_cast<std::size_t>(i)].leaf()) split_leaf(tree, i, 0);
  }
}

// A tenth too much and too little from leaf to leaf, halves of the same parents: fresh gathers even
// it out, so that residual and error are a tenth, and the flux is right. A gather of 64 rays sees
// the pattern with a noise of a tenth of ρE/√64 at most, .6% of E, which is taken off.
TEST(ErrorEstimate, ACheckerboardOfATenth) {
  constexpr int kSplits = 6;
  Furnace f(0.5);
  f.run.change([&](PatchTree& tree) {
    split_all(tree, kSplits);
    set_even(tree, f.truth());
    const std::size_t k = static_cast<std::size_t>(tree.view().k()) * kChannels;
    for (const Element& e : tree.elements)
      for (std::size_t c = 0; !e.leaf() && c < kChannels; ++c)
        for (const std::int32_t side : {0, 1}) {
          const auto child = static_cast<std::size_t>(e.child + side);
          if (tree.elements[child].leaf()) tree.e[child * k + c] *= side ? 1.1 : 0.9;
        }
  });
  const ErrorEstimate e = estimate(f.run, kFew);
  EXPECT_NEAR(e.error, 0.1, 0.004);
  EXPECT_NEAR(e.local, 0.1, 0.004);
  EXPECT_NEAR(e.closure, 1, 0.01);
  EXPECT_LT(e.low, 0.1);
  EXPECT_GT(e.high, 0.1);
}

// The same with one leaf of 384 seven times too bright: its square, 36/384, is ten times that of all
// others, .01. Each of the two points it gets counts for .3 of what is counted, and for no more by
// what leaving either out would change: together .01 / (1 - .6). The interval knows it in full.
TEST(ErrorEstimate, OneBadLeafDoesNotDecideIt) {
  constexpr int kSplits = 6;
  constexpr double kRest = 0.1, kBad = 6, kMost = 0.3, kLeaves = 6 * 64;
  Furnace f(0.5);
  std::size_t patch = 0;
  f.run.change([&](PatchTree& tree) {
    split_all(tree, kSplits);
    set_even(tree, f.truth());
    const std::size_t k = static_cast<std::size_t>(tree.view().k()) * kChannels;
    bool bad = patch++ == 3;
    for (const Element& e : tree.elements)
      for (std::size_t c = 0; !e.leaf() && c < kChannels; ++c)
        for (const std::int32_t side : {0, 1}) {
          const auto child = static_cast<std::size_t>(e.child + side);
          if (!tree.elements[child].leaf()) continue;
          tree.e[child * k + c] *= bad ? 1 + kBad : side ? 1 + kRest : 1 - kRest;
          if (c + 1 == kChannels) bad = false;
        }
  });
  const ErrorEstimate e = estimate(f.run, kFew);
  EXPECT_NEAR(e.error, std::sqrt(squared(kRest) / (1 - 2 * kMost)), 0.01);
  EXPECT_GT(e.high, std::sqrt(squared(kRest) + squared(kBad) / kLeaves));
}

// A lamp as large as the ceiling over it, a beam between: most points see a part of the lamp, which
// 128 rays tell to some percent, and 256 such points the error to 1.4% at best. Asked for half a
// percent they take more rays, until noise alone would be taken for no more than that: its square
// is the standard deviation of the error's, which is within three of them of what eight times as
// many points of 4,096 rays each find. A furnace, whose gathers have no noise, takes none.
TEST(ErrorEstimate, WhereNoiseWouldHideWhatIsAskedPointsTakeMoreRays) {
  constexpr double kAsked = 0.005;
  Builder b("beam");
  const PaintId black = b.paint("black", 0);
  b.rectangle("lamp", b.paint("lamp", 0, kExitance / kPi), {-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  b.rectangle("ceiling", black, {-2, -2, 3}, {0, 4, 0}, {4, 0, 0});
  b.rectangle("beam", black, {-.5, -2, 1.5}, {0, 4, 0}, {1, 0, 0});
  Bench bench(b.take());
  SolvedStore run(solved(bench, 0.01), kArena);
  const ErrorEstimate fine = estimate(run, {.points = 2048, .directions = 4096, .seed = 99});
  EstimateSettings settings{.points = 256, .directions = 128};
  const std::uint64_t rays = 256 * 128;
  for (settings.seed = 1; settings.seed <= 6; ++settings.seed) {
    settings.asked = 0;
    EXPECT_EQ(estimate(run, settings).rays, rays);
    settings.asked = kAsked;
    const ErrorEstimate found = estimate(run, settings);
    EXPECT_GT(found.rays, rays);
    EXPECT_NEAR(squared(found.error), squared(fine.error), 3 * squared(kAsked));
  }
  Furnace furnace(0.5);
  settings.asked = 1e-4;
  EXPECT_EQ(estimate(furnace.run, settings).rays, rays);
}

void expect_same(const ErrorEstimate& a, const ErrorEstimate& b) {
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
  EXPECT_EQ(a.closure, b.closure);
  EXPECT_EQ(a.closure_within, b.closure_within);
}

TEST(ErrorEstimate, TheSameBitsForAnyThreadsAndArena) {
  Bench bench(generated({.kind = "rooms", .grid = 2}));
  const SolveOptions options = solved(bench);
  ErrorEstimate first;
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    SolvedStore run(options, kArena);
    first = estimate(run, kFew);
    EXPECT_GT(first.error, 0);
    EXPECT_EQ(run.store().counters().evictions, 0u);
  }
  {
    const tbb::global_control three(tbb::global_control::max_allowed_parallelism, 3);
    SolvedStore run(options, kArena);
    expect_same(estimate(run, kFew), first);
  }
  const Result<Plan> planned = plan(options);
  ASSERT_TRUE(planned.ok());
  SolvedStore tiny(options, planned->smallest_arena);
  expect_same(estimate(tiny, kFew), first);
  EXPECT_GT(tiny.store().counters().evictions, 0u);
}

}  // namespace
}  // namespace atrium::testing
