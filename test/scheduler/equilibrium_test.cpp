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

  // Plate 0 shines; light goes to and fro. The K of it is put in by hand.
  void sweep() {
    double change2 = 0;
    for (const std::uint32_t c : {0u, 1u}) {
      const double was = e_[c] + pending(c), other = e_[1 - c] + pending(1 - c);
      e_[c] = kRho * other + (c == 1 ? kExitance : 0);
      const Spectrum gained{e_[c] - was}, light{e_[c]};
      equilibrium_->set_row(equilibrium_->units_of(ClusterId(c))[0],
                            {{equilibrium_->units_of(ClusterId(1 - c))[0], {kRho, kRho, kRho}, {}}});
      equilibrium_->gathered(ClusterId(c), std::span(&gained, 1), std::span(&light, 1));
      change2 += gained.x * gained.x;
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

TEST_F(TwoPlates, OneSweepAndItsCorrectionAreNearlyTheAnswer) {
  sweep();
  // Corrections look ahead a thousand bounces, and of these a share of 1/(1 - ρ) / 1000 is missing.
  EXPECT_NEAR(e_[0] + pending(0), kFirst, 0.02 * kFirst);
  EXPECT_NEAR(e_[1] + pending(1), kSecond, 0.02 * kSecond);
}

TEST_F(TwoPlates, FourSweepsAreTheAnswerWhereAPlainIterationTakesFortyFor1em4) {
  for (int i = 0; i < 4; ++i) sweep();
  EXPECT_NEAR(e_[0] + pending(0), kFirst, 1e-6 * kFirst);
  EXPECT_NEAR(e_[1] + pending(1), kSecond, 1e-6 * kSecond);
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
