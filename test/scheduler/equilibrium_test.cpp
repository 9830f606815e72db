// The coarse system of two plates so close that each sees nothing but the other: E = M' + ρE' on
// either, functions constant on units, so that one sweep and its correction are the whole answer;
// and what becomes of corrections by rows that are not those of the exchange.
#include "scheduler/equilibrium.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "test/pagestore/simulated_disk.h"

namespace atrium {
namespace {

// Squares of such edges, cluster by cluster.
Model squares(const std::vector<std::vector<double>>& edges) {
  Model m;
  for (const std::vector<double>& cluster : edges) {
    Cluster c;
    c.first_patch = std::uint32_t(m.patches.size());
    c.patch_count = std::uint32_t(cluster.size());
    for (const double a : cluster) {
      Patch p;
      p.cluster = ClusterId(m.clusters.size());
      p.first_vertex = std::uint32_t(m.vertices.size());
      p.vertex_count = 4;
      m.patches.push_back(p);
      for (const Vec3& v : {Vec3{0, 0, 0}, Vec3{a, 0, 0}, Vec3{a, a, 0}, Vec3{0, a, 0}})
        m.vertices.push_back(v);
    }
    m.clusters.push_back(c);
  }
  return m;
}

Model two_plates() { return squares({{1}, {1}}); }

class TwoPlates : public testing::Test {
 protected:
  static constexpr double kRho = 0.9, kExitance = 1;

  TwoPlates() {
    for (std::uint32_t c = 0; c < 2; ++c) order_.push_back(ClusterId(c));
    equilibrium_.emplace(model_, order_);
    EXPECT_EQ(equilibrium_->units(), 4u);  // each cluster's patch, and what is left of it: nothing
  }

  // Where it is saved; made when it is asked for.
  ClusterStore& store() {
    if (!store_)
      store_ = ClusterStore::create("run", {.arena_bytes = kGranule, .disk = &disk_}).value();
    return *store_;
  }

  double pending(std::uint32_t c) const { return equilibrium_->pending(ClusterId(c))[0].x; }

  // Plate 0 shines; light goes to and fro. The K of it, which need not be true, is put in by hand.
  // over: times what a gather changes, that is taken.
  void sweep(double over = 1) {
    double change2 = 0;
    for (const std::uint32_t c : {0u, 1u}) {
      const double was = e_[c] + pending(c), other = e_[1 - c] + pending(1 - c);
      const double change = rho_ * other + (c == 1 ? kExitance : 0) - was;
      e_[c] = was + over * change;
      const PatchGain gain{Spectrum{over * change}, Spectrum{(over - 1) * change}};
      equilibrium_->set_row(equilibrium_->units_of(ClusterId(c))[0],
                            {{equilibrium_->units_of(ClusterId(1 - c))[0], {row_, row_, row_}}});
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
  SimulatedDisk disk_;
  std::unique_ptr<ClusterStore> store_;
  std::array<double, 2> e_{};
  double rho_ = kRho;        // of the exchange
  float row_ = float(kRho);  // what K has for it
};

// What is left is that rows are kept in float (6e-8 of ρ) and corrections look 1e7 bounces ahead.
constexpr double kNearly = 1e-5;

TEST_F(TwoPlates, OneSweepAndItsCorrectionAreTheAnswerWhereAPlainIterationTakesFiftyFor1em5) {
  sweep();
  EXPECT_NEAR(e_[0] + pending(0), kFirst, kNearly * kFirst);
  EXPECT_NEAR(e_[1] + pending(1), kSecond, kNearly * kSecond);
}

// An edit lights plate 0: both take what comes of it, and then one alone gathers, by rows that are
// not K's. What the other is given stays what K carries of all that plate 0 holds.
TEST_F(TwoPlates, APlateThatIsNotGatheredToIsGivenWhatTheOtherHoldsByK) {
  std::vector<UnitEdit> edits(equilibrium_->units());
  std::array<std::uint32_t, 2> unit{};
  for (const std::uint32_t c : {0u, 1u}) unit[c] = equilibrium_->units_of(ClusterId(c))[0];
  for (const std::uint32_t c : {0u, 1u}) {
    equilibrium_->set_row(unit[c], {{unit[1 - c], {}, 1}});
    edits[unit[c]] = {.before = unit[c], .reflectance = Spectrum{kRho}};
  }
  edits[unit[0]].change = Spectrum{kExitance};
  Equilibrium now(model_, order_);
  ASSERT_TRUE(equilibrium_->leave_factors(store()).ok());
  ASSERT_TRUE(now.take_over(store(), equilibrium_->units(), edits).ok());
  const auto given = [&](std::uint32_t c) { return now.pending(ClusterId(c))[0].x; };
  EXPECT_NEAR(given(0), kFirst, kNearly * kFirst);
  EXPECT_NEAR(given(1), kSecond, kNearly * kSecond);
  now.reach(ClusterId(0u));
  EXPECT_EQ(now.reached(ClusterId(0u)), Reached::kNext);
  EXPECT_EQ(now.flux_awaited(), 0);  // of both it is pending, but no sweep will see it
  now.begin_sweep();
  EXPECT_NEAR(now.flux_awaited(), given(0), kNearly);  // of 1 m²
  double e = 0;
  for (const double rho : {.8, .7, .7}) {
    const double was = e + given(0), change = rho * given(1) - was;
    e = was + change;
    const PatchGain gain{Spectrum{change}, Spectrum{0}};
    now.gathered(ClusterId(0u), std::span(&gain, 1));
    now.correct(std::abs(change));
    const double expected = kExitance + kRho * (e + given(0));
    EXPECT_NEAR(given(1), expected, kNearly * expected);
  }
  EXPECT_EQ(now.reached(ClusterId(1u)), Reached::kNot);
  EXPECT_GT(now.come_by_itself(ClusterId(1u)), given(1) / 2);
}

// Plates lose half of what they had while K has hardly any get out: it asks for some fifty times
// that, and takes what is left.
TEST_F(TwoPlates, NoCorrectionTakesMoreLightThanThereIs) {
  constexpr float kRow = 0.99f;
  constexpr double kHad = 1, kLeft = 0.5;
  const auto gather_all = [&](const auto& change_of) {
    for (const std::uint32_t c : {0u, 1u}) {
      const PatchGain gain{Spectrum{change_of(c)}, Spectrum{0}};
      equilibrium_->set_row(equilibrium_->units_of(ClusterId(c))[0],
                            {{equilibrium_->units_of(ClusterId(1 - c))[0], {kRow, kRow, kRow}}});
      equilibrium_->gathered(ClusterId(c), std::span(&gain, 1));
    }
    equilibrium_->correct(1);
  };
  gather_all([&](std::uint32_t) { return kHad; });
  EXPECT_GT(pending(0), 10 * kHad);
  gather_all([&](std::uint32_t c) { return kLeft - kHad - pending(c); });
  for (const std::uint32_t c : {0u, 1u}) EXPECT_NEAR(pending(c), -kLeft, 1e-9 * kHad);
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

// Rows of κ for an exchange of ρ. A sweep leaves ρ² of the error ε of E1, so changes it by
// -(1 - ρ²) ε, and K takes -(1 - ρ²) κ²/(1 - κ²) ε to be still to come. Where the share t of that
// is taken ε' = (ρ² - t (1 - ρ²) κ²/(1 - κ²)) ε. With ρ .5 and κ .94 that is .25 - 5.69 t: whole
// corrections turn the error over and make it 5.44 times as large, sweep after sweep, less than the
// growth at which a correction looks less far ahead. A share of below .22 settles.
TEST_F(TwoPlates, RowsThatOverstateTheExchangeSettleNevertheless) {
  rho_ = 0.5, row_ = 0.94f;
  const double exact = kExitance / (1 - rho_ * rho_), far = 1 / (1 - double(row_) * row_) - 1;
  const double grows = rho_ * rho_ - (1 - rho_ * rho_) * far;
  ASSERT_LT(grows, -1);
  const auto error = [&] { return e_[1] + pending(1) - exact; };
  sweep();
  EXPECT_NEAR(error(), -grows * exact, kNearly * exact);
  const double whole = std::abs(grows * error());
  sweep();
  EXPECT_LT(std::abs(error()), 0.6 * whole);
  for (int i = 0; i < 60; ++i) sweep();
  EXPECT_NEAR(e_[1] + pending(1), exact, 1e-6 * exact);
  EXPECT_NEAR(e_[0], rho_ * exact, 1e-6 * exact);
}

// Rows that understate it are borne out: with κ .5 and ρ .9, ε' = (.81 - .19/3) ε, all of it taken.
TEST_F(TwoPlates, RowsThatUnderstateTheExchangeAreTrusted) {
  row_ = 0.5f;
  const double factor = kRho * kRho - (1 - kRho * kRho) / 3;
  double error = -kSecond;
  for (int i = 0; i < 20; ++i) {
    sweep();
    error *= factor;
    EXPECT_NEAR(e_[1] + pending(1) - kSecond, error, kNearly * kSecond) << i;
  }
}

// Clusters of one unit each that sends itself half of what it has: of a gain c, as much is still to
// come. Gains are given by hand, and what of their correction is taken is asked for.
class Trust : public testing::Test {
 protected:
  Trust() {
    for (std::uint32_t c = 0; c < 2; ++c) order_.push_back(ClusterId(c));
    equilibrium_.emplace(model_, order_);
    for (const ClusterId c : order_) {
      const std::uint32_t u = equilibrium_->units_of(c)[0];
      equilibrium_->set_row(u, {{u, {.5, .5, .5}}});
      const PatchGain plenty{Spectrum{1000}, Spectrum{0}};  // no correction takes all of it
      equilibrium_->gathered(c, std::span(&plenty, 1));
    }
  }

  // Shares of the corrections that are taken.
  std::array<double, 2> sweep(const std::array<double, 2>& gains) {
    for (const ClusterId c : order_) {
      const PatchGain gain{Spectrum{gains[c.value]}, Spectrum{0}};
      equilibrium_->gathered(c, std::span(&gain, 1));
    }
    equilibrium_->correct(1);
    std::array<double, 2> shares;
    for (const ClusterId c : order_)
      shares[c.value] = equilibrium_->pending(c)[0].x / gains[c.value];
    return shares;
  }

  Model model_ = two_plates();
  std::vector<ClusterId> order_;
  std::optional<Equilibrium> equilibrium_;
};

// One unit's gains turn back and forth, those of the other go on.
TEST_F(Trust, WhatIsTakenBackIsGivenLessAndLessDownToAFloorAndTheOtherUnitsIsNot) {
  double last = sweep({1, 1})[0], gain = 1;
  EXPECT_NEAR(last, 1, kNearly);
  for (int i = 0; i < 6; ++i) {
    gain = -gain;
    const std::array<double, 2> shares = sweep({gain, 1});
    EXPECT_NEAR(shares[0], last / 2, kNearly) << i;
    EXPECT_NEAR(shares[1], 1, kNearly) << i;
    last = shares[0];
  }
  for (int i = 0; i < 20; ++i) {
    gain = -gain;
    EXPECT_NEAR(sweep({gain, 1})[0], last, kNearly) << i;
  }
  EXPECT_GT(last, 100 * kNearly);
}

TEST_F(Trust, WhatHoldsAgainIsGivenWholeAgainMoreSlowlyThanItWasTaken) {
  for (int i = 0; i < 4; ++i) sweep({i % 2 ? -1.0 : 1.0, 1});  // thrice taken back
  double last = 1.0 / 8;
  int sweeps = 0;
  for (; last < 1 - kNearly && sweeps < 20; ++sweeps) {
    const double share = sweep({-1, 1})[0];
    EXPECT_GT(share, last);
    last = share;
  }
  EXPECT_NEAR(last, 1, kNearly);
  EXPECT_GT(sweeps, 3);
}

// Gains that turn back are not held against it where they fall: .8 of the last each time.
TEST_F(Trust, WhatTurnsBackButSettlesKeepsGettingItWhole) {
  double gain = 1;
  for (int i = 0; i < 20; ++i, gain *= -0.8) EXPECT_NEAR(sweep({gain, 1})[0], 1, kNearly) << i;
}

// A square of a tenth's edge is a hundredth of its cluster: no unit of its own.
TEST(Equilibrium, PatchesComeByUnitThoseOfTheRestFirst) {
  const Model model = squares({{1}, {.1, 1, .1, 1}});
  const std::vector<ClusterId> order{ClusterId(0u), ClusterId(1u)};
  const Equilibrium equilibrium(model, order);
  EXPECT_EQ(equilibrium.by_unit(ClusterId(0u)), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(equilibrium.by_unit(ClusterId(1u)), (std::vector<std::uint32_t>{0, 2, 1, 3}));
  const std::span<const std::uint32_t> units = equilibrium.units_of(ClusterId(1u));
  EXPECT_EQ(units[0], units[2]);
  EXPECT_NE(units[1], units[3]);
}

TEST_F(TwoPlates, WhatIsSavedGoesOnAsIfNothingHadHappened) {
  sweep();
  ASSERT_TRUE(equilibrium_->save(store()).ok());
  const std::array<double, 2> e = e_;
  sweep();
  const double expected = pending(0);

  equilibrium_.emplace(model_, order_);
  ASSERT_TRUE(equilibrium_->restore(store()).ok());
  e_ = e;
  sweep();
  EXPECT_EQ(pending(0), expected);
  EXPECT_NE(expected, 0);
}

TEST_F(TwoPlates, RecordsOfAnotherLengthAreRefused) {
  sweep();
  EXPECT_FALSE(equilibrium_->restore(store()).ok());  // none is there
  ASSERT_TRUE(equilibrium_->save(store()).ok());
  const RecordId id = record_id(RecordKind::kEquilibrium, 0);
  const auto whole = store().stream_in(id);
  ASSERT_TRUE(whole.ok());
  std::vector<std::byte> bytes(whole->begin(), whole->end());
  bytes.pop_back();
  ASSERT_TRUE(store().stream_out(id, bytes).ok());
  EXPECT_FALSE(equilibrium_->restore(store()).ok());
  bytes.resize(bytes.size() + 2);
  ASSERT_TRUE(store().stream_out(id, bytes).ok());
  EXPECT_FALSE(equilibrium_->restore(store()).ok());
}

}  // namespace
}  // namespace atrium
