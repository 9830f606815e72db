// Energy, scale, and scenes at the edge of having any light.
#include <gtest/gtest.h>

#include "test/physics/rooms.h"

namespace atrium::testing {
namespace {

SolveOptions asked(Bench& bench, double error) {
  SolveOptions o = bench.options();
  o.error = error;
  return o;
}

TEST(Energy, WhatTheCornellRoomEmitsItAbsorbs) {
  Bench bench(generated({.kind = "cornell"}));
  SolvedRun run(asked(bench, 0.02));
  ASSERT_TRUE(run.ok());
  const SolveSummary& s = run.summary();
  EXPECT_GT(s.flux_emitted, 0);
  EXPECT_NEAR(s.flux_absorbed + s.flux_escaped, s.flux_emitted, 0.01 * s.flux_emitted);
  // The summary's figures are those of the records.
  const Balance b = balance(run);
  EXPECT_NEAR(b.emitted, s.flux_emitted, 1e-9 * s.flux_emitted);
  EXPECT_NEAR(b.absorbed, s.flux_absorbed, 1e-9 * s.flux_emitted);
}

// A box without a bottom stands on the floor: what it covers is dark, and none of the lamp's flux
// is lost or made up there. Where no light reaches there need be no surface to ask.
TEST(Energy, NoLightUnderABox) {
  const Vec3 lo{0}, hi{4, 4, 3};
  Builder b("room with a box");
  const PaintId grey = b.paint("grey", .6), lamp = b.paint("lamp", .6, 2000);
  b.walls_and_floor(grey, lo, hi).ceiling_with_lamp(grey, lamp, lo, hi, 1);
  b.standing_box("box", grey, {1.1, 1.3, 0}, {2.2, 2.1, .9});
  Bench bench(b.take());
  SolvedRun run(asked(bench, 0.01));
  ASSERT_TRUE(run.ok());
  const double beside = illuminance(run, {{3, 3, 0}, {0, 0, 1}});
  EXPECT_GT(beside, 100);
  for (const Vec3& x : {Vec3{1.65, 1.7, 0}, Vec3{1.3, 1.5, 0}, Vec3{2, 1.9, 0}}) {
    const std::optional<SurfaceSample> s = run.at({x, {0, 0, 1}});
    EXPECT_LT(s ? luminance(s->irradiance) : 0, 0.02 * beside) << x.x << ", " << x.y;
  }
  const Balance sum = balance(run);
  EXPECT_NEAR(sum.absorbed, sum.emitted, 0.01 * sum.emitted);
}

GeneratedModel transformed(GeneratedModel model, double scale, const Vec3& by) {
  for (Vec3& v : model.vertices) v = scale * v + by;
  return model;
}

// Irradiance at points of a Cornell-like room that was scaled and moved, against that of the room;
// the tolerance is relative to the larger of E there and its mean.
constexpr double kAsked = 0.01;
void expect_same_light(double scale, const Vec3& by, double tolerance, double other_links) {
  const GeneratedModel model = generated({.kind = "cornell"});
  Bench here(model), there(transformed(model, scale, by));
  SolveOptions of_a = asked(here, kAsked), of_b = asked(there, kAsked);
  of_a.residual = of_b.residual =
      1e-5;  // to the last level: an estimate may take one's coarser answer
  SolvedRun a(of_a), b(of_b);
  ASSERT_TRUE(a.ok() && b.ok());
  const double elements = double(a.summary().elements), links = double(a.summary().links);
  EXPECT_NEAR(double(b.summary().elements), elements, other_links * elements);
  EXPECT_NEAR(double(b.summary().links), links, other_links * links);
  double mean = 0;
  std::vector<std::pair<double, double>> pairs;
  for (const Probe& p : probes_on(model, 6)) {
    const std::optional<SurfaceSample> x = a.at(p);
    const std::optional<SurfaceSample> y = b.at({scale * p.x + by, p.normal});
    ASSERT_EQ(x.has_value(), y.has_value());
    if (!x) continue;  // under a box, where no light reaches
    pairs.emplace_back(luminance(x->irradiance), luminance(y->irradiance));
    mean += pairs.back().first;
  }
  ASSERT_GT(pairs.size(), 100u);
  mean /= double(pairs.size());
  for (const auto& [x, y] : pairs) EXPECT_NEAR(y, x, tolerance * std::max(x, mean));
}

// Powers of two scale every coordinate without rounding: nothing but exponents differs, however
// small or large the room. What is left is the probes' own rounding.
TEST(Scale, ARoomOfAMicrometre) { expect_same_light(std::ldexp(1, -22), {0, 0, 0}, 1e-12, 0); }
TEST(Scale, ARoomOfAMillionMetres) { expect_same_light(std::ldexp(1, 18), {0, 0, 0}, 1e-12, 0); }

// Coordinates of 1e6 m carry 1e-10 m, 2e-11 of the room: enough to tip a link that stands on the
// edge of being refined. A few may tip; what they change at any one point stays below a twentieth
// of the error asked for, root mean square.
TEST(Scale, ARoomAMillionMetresAway) { expect_same_light(1, {1e6, -1e6, 1e6}, kAsked / 20, 0.002); }

TEST(Darkness, ASceneWithoutLightsIsRefused) {
  Builder b("dark");
  b.walls_and_floor(b.paint("grey", .5), Vec3{0}, Vec3{3}).ceiling(0, Vec3{0}, Vec3{3});
  Bench bench(b.take());
  const Result<SolveSummary> s = solve(bench.options(), {}, {});
  ASSERT_FALSE(s.ok());
  EXPECT_EQ(s.status().code(), Code::kScene);
  EXPECT_FALSE(s.status().remedy().empty());
}

// A lamp that shines away from a plate that faces away from it, in the open.
TEST(Darkness, NothingSeesAnything) {
  Builder b("apart");
  const PaintId grey = b.paint("grey", .5), lamp = b.paint("lamp", .5, 1000);
  b.rectangle("lamp", lamp, {0, 0, 1}, {1, 0, 0}, {0, 1, 0});   // up
  b.rectangle("plate", grey, {0, 0, 0}, {0, 1, 0}, {1, 0, 0});  // down
  Bench bench(b.take());
  SolvedRun run(asked(bench, 0.02));
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run.summary().exit_code, 0);
  EXPECT_EQ(run.summary().flux_absorbed, 0);
  EXPECT_NEAR(run.summary().flux_emitted, 1000 * kPi, 1e-9 * 1000 * kPi);
  EXPECT_NEAR(run.summary().flux_escaped, run.summary().flux_emitted, 1e-9 * 1000 * kPi);
}

}  // namespace
}  // namespace atrium::testing
