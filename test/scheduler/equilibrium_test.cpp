// The coarse system of two plates so close that each sees nothing but the other: E = M' + ρE' on
// either, functions constant on units, so that one sweep and its correction are the whole answer.
#include "scheduler/equilibrium.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace atrium {
namespace {

// Two clusters of one unit square each.
Model two_plates() {
  Model m;
  for (std::uint32_t c = 0; c < 2; ++c) {
    Patch p;
    p.cluster = ClusterId(c);
    p.first_vertex = 4 * c;
    p.vertex_count = 4;
    m.patches.push_back(p);
    for (const Vec3& v : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}})
      m.vertices.push_back(v);
    Cluster cluster;
    cluster.first_patch = c;
    cluster.patch_count = 1;
    m.clusters.push_back(cluster);
  }
  return m;
}

class TwoPlates : public testing::Test {
 protected:
  static constexpr double kRho = 0.9, kExitance = 1;

  TwoPlates() {
    for (std::uint32_t c = 0; c < 2; ++c) order_.push_back(ClusterId(c));
    equilibrium_.emplace(model_, order_);
    EXPECT_EQ(equilibrium_->units(), 4u);  // each cluster's patch, and what is left of it: nothing
  }

  double pending(std::uint32_t c) const { return equilibrium_->pending(ClusterId(c))[0].x; }

  // Plate 0 shines; light goes to and fro. The K of it is put in by hand. over: times what a gather
  // changes, that is taken.
  void sweep(double over = 1) {
    double change2 = 0;
    for (const std::uint32_t c : {0u, 1u}) {
      const double was = e_[c] + pending(c), other = e_[1 - c] + pending(1 - c);
      const double change = kRho * other + (c == 1 ? kExitance : 0) - was;
      e_[c] = was + over * change;
      const PatchGain gain{Spectrum{over * change}, Spectrum{(over - 1) * change}};
      equilibrium_->set_row(equilibrium_->units_of(ClusterId(c))[0],
                            {{equilibrium_->units_of(ClusterId(1 - c))[0], {kRho, kRho, kRho}}});
      equilibrium_->gathered(ClusterId(c), std::span(&gain, 1));
      change2 += change * change;
    }
    equilibrium_->correct(std::sqrt(change2));
  }

  // E0 = ρE1, E1 = ρE0 + M.
  static constexpr double kFirst = kRho * kExitance / (1 - kRho * kRho);
  static constexpr double kSecond = kExitance / (1 - kRho * kRho);

  Model model_ = two_plates();
  std::vector<ClusterId> order_;
  std::optional<Equilibrium> equilibrium_;
  std::array<double, 2> e_{};
};

// What is left is that rows are kept in float (6e-8 of ρ) and corrections look 1e7 bounces ahead.
constexpr double kNearly = 1e-5;

TEST_F(TwoPlates, OneSweepAndItsCorrectionAreTheAnswerWhereAPlainIterationTakesFiftyFor1em5) {
  sweep();
  EXPECT_NEAR(e_[0] + pending(0), kFirst, kNearly * kFirst);
  EXPECT_NEAR(e_[1] + pending(1), kSecond, kNearly * kSecond);
}

TEST_F(TwoPlates, WhatASweepTookBeyondItsGathersIsPartOfTheResidual) {
  sweep(1.5);
  EXPECT_NEAR(e_[0] + pending(0), kFirst, kNearly * kFirst);
  EXPECT_NEAR(e_[1] + pending(1), kSecond, kNearly * kSecond);
}

TEST_F(TwoPlates, FluxPendingIsWhatIsMissingOfTheAnswer) {
  sweep();
  EXPECT_NEAR(equilibrium_->flux_pending(), kFirst + kSecond - e_[0] - e_[1],
              kNearly * (kFirst + kSecond));
}

// Of a cluster whose other patch is a black back: units hold lit area only, or what the lit patch
// has would count as spread over both, and as half as bright where it is read.
TEST(Equilibrium, InertPatchesAreNoPartOfAnyUnit) {
  Model model = two_plates();
  model.patches[1].cluster = ClusterId(0u);
  model.patches[1].inert = 1;
  model.clusters.pop_back();
  model.clusters[0].patch_count = 2;
  const std::vector<ClusterId> order{ClusterId(0u)};
  Equilibrium equilibrium(model, order);
  const std::span<const std::uint32_t> units = equilibrium.units_of(ClusterId(0u));
  EXPECT_NE(units[0], units[1]);
  const std::vector<PatchGain> gains{{Spectrum{3}, Spectrum{0}}, {}};
  equilibrium.set_row(units[0], {{units[0], {.5, .5, .5}}});
  equilibrium.gathered(ClusterId(0u), gains);
  equilibrium.correct(1);
  // x = .5 (3 + x), over 1 m².
  EXPECT_NEAR(equilibrium.pending(ClusterId(0u))[0].x, 3, kNearly);
  EXPECT_EQ(equilibrium.pending(ClusterId(0u))[1].x, 0);
  EXPECT_NEAR(equilibrium.flux_pending(), 3, kNearly);
}

TEST_F(TwoPlates, WhatIsSavedGoesOnAsIfNothingHadHappened) {
  sweep();
  const std::vector<std::byte> record = equilibrium_->saved();
  const std::array<double, 2> e = e_;
  sweep();
  const double expected = pending(0);

  equilibrium_.emplace(model_, order_);
  ASSERT_TRUE(equilibrium_->restore(record).ok());
  e_ = e;
  sweep();
  EXPECT_EQ(pending(0), expected);
  EXPECT_NE(expected, 0);
}

TEST_F(TwoPlates, ARecordOfAnotherLengthIsRefused) {
  sweep();
  std::vector<std::byte> record = equilibrium_->saved();
  record.pop_back();
  EXPECT_FALSE(equilibrium_->restore(record).ok());
  record.resize(record.size() + 2);
  EXPECT_FALSE(equilibrium_->restore(record).ok());
  EXPECT_FALSE(equilibrium_->restore({}).ok());
}

}  // namespace
}  // namespace atrium
