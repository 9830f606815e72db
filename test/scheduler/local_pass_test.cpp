// What a local pass puts right, and what it leaves, in rooms whose light is known.
#include "scheduler/local_pass.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "solver/element_tree.h"
#include "test/physics/rooms.h"
#include "test/scheduler/solved_store.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kArena = std::size_t{32} << 20;
constexpr double kExitance = 100, kRho = 0.5, kExpected = kExitance / (1 - kRho);

class FurnaceMended : public ::testing::Test {
 protected:
  FurnaceMended() : run_(solved(bench_, 0.2), kArena) {
    order_.resize(run_.model().clusters.size());
    for (std::size_t c = 0; c < order_.size(); ++c) order_[c] = ClusterId(c);
    equilibrium_.emplace(run_.model(), order_);
  }

  // Both sweeps, without what mends send on: the coarse system knows of no links. Returns the rays.
  std::uint64_t local_pass(const LocalSettings& settings = {}) {
    std::uint64_t rays = 0;
    mend(settings, rays);
    return rays;
  }
  void mend(const LocalSettings& settings, std::uint64_t& rays) {
    const Result<BrightSources> bright = BrightSources::find(run_.model(), run_.store());
    ASSERT_TRUE(bright.ok());
    for (const ClusterId c : order_) {
      const auto report =
          measure_mend(run_.store(), run_.fresh(), *bright, c, settings, *equilibrium_);
      ASSERT_TRUE(report.ok()) << report.status().message();
      rays += report->refined.rays;
    }
    equilibrium_->spread_gains();
    for (const ClusterId c : order_) {
      const auto report = put_in_mend(run_.store(), c, *equilibrium_);
      ASSERT_TRUE(report.ok()) << report.status().message();
    }
  }

  // By patch, of the root's mean.
  std::vector<double> irradiance() {
    std::vector<double> e;
    run_.change([&](PatchTree& tree) { e.push_back(tree.e[0]); });
    return e;
  }

  Bench bench_{generated({.kind = "furnace", .rho = kRho, .exitance = kExitance, .shape = "cube"})};
  SolvedStore run_;
  std::vector<ClusterId> order_;
  std::optional<Equilibrium> equilibrium_;
};

// Every ray brings what is there already: nothing is mended.
TEST_F(FurnaceMended, WhatIsRightStays) {
  run_.change([](PatchTree& tree) { set_even(tree, kExpected); });
  local_pass();
  for (const double e : irradiance()) EXPECT_NEAR(e, kExpected, 1e-9 * kExpected);
}

// One wall of six a fifth too bright: rays from it meet the others alone, which are right. They
// see a fifth of it, at ρ = .5, and rise by .1 × .2 E, the Monte Carlo error of some thousand rays apart.
TEST_F(FurnaceMended, AWallThatIsWrongIsPutRight) {
  constexpr double kTooBright = 1.2, kSeen = 0.2, kScatter = 0.01;
  std::size_t patch = 0;
  run_.change([&](PatchTree& tree) {
    set_even(tree, patch++ == 0 ? kTooBright * kExpected : kExpected);
  });
  ASSERT_EQ(patch, 6u);
  local_pass();
  const std::vector<double> e = irradiance();
  EXPECT_NEAR(e[0], kExpected, 1e-9 * kExpected);
  for (std::size_t p = 1; p < e.size(); ++p)
    EXPECT_NEAR(e[p], (1 + kRho * kSeen * (kTooBright - 1)) * kExpected, kScatter * kExpected);
}

constexpr int kSplits = 6;

void split_all(PatchTree& tree, int times) {
  for (int t = 0; t < times; ++t) {
    const auto count = static_cast<std::int32_t>(tree.elements.size());
    for (std::int32_t i = 0; i < count; ++i)
      if (tree.elements[static_cast<std::size_t>(i)].leaf()) split_leaf(tree, i, 0);
  }
}

// The same wall of many leaves, a half of them without light, which are one piece if that may be as
// large as the wall: as many rays as for a wall of one leaf, and what is too much goes in proportion,
// so that what has no light stays so.
TEST_F(FurnaceMended, LeavesOfOnePieceAreMendedAlike) {
  constexpr double kTooBright = 1.2, kScatter = 0.02;
  const LocalSettings whole{.piece = std::numeric_limits<double>::infinity()};
  const std::uint64_t rays = local_pass(whole);
  std::size_t patch = 0, dark = 0, leaves = 0;
  run_.change([&](PatchTree& tree) {
    set_even(tree, kExpected);
    if (patch++ > 0) return;
    split_all(tree, kSplits);
    set_even(tree, 2 * kTooBright * kExpected);
    const std::size_t k = std::size_t(tree.view().k()) * kChannels;
    std::fill_n(tree.e.begin(), kChannels, kTooBright * kExpected);
    for (std::size_t i = 0; i < tree.elements.size(); ++i) {
      const Element& x = tree.elements[i];
      leaves += x.leaf();
      if (!x.leaf() || x.centroid.x > tree.elements[0].centroid.x) continue;
      std::fill_n(tree.e.begin() + std::ptrdiff_t(i * k), k, 0.0);
      ++dark;
    }
  });
  ASSERT_EQ(2 * dark, leaves);
  EXPECT_EQ(local_pass(whole), rays);
  patch = 0;
  run_.change([&](PatchTree& tree) {
    if (patch++ > 0) return;
    const std::size_t k = std::size_t(tree.view().k()) * kChannels;
    EXPECT_NEAR(tree.e[0], kExpected, kScatter * kExpected);
    for (std::size_t i = 0; i < tree.elements.size(); ++i) {
      const Element& x = tree.elements[i];
      if (!x.leaf()) continue;
      const double expected = x.centroid.x < tree.elements[0].centroid.x ? 0 : 2 * kExpected;
      EXPECT_NEAR(tree.e[i * k], expected, 2 * kScatter * kExpected);
    }
  });
}

// Leaves across whose piece the light varies by more than half of its mean are wrong by different
// amounts: each is a piece of its own then, however small.
TEST_F(FurnaceMended, LeavesOfAnUnevenPieceAreMendedOneByOne) {
  const LocalSettings whole{.piece = std::numeric_limits<double>::infinity()};
  constexpr double kVaries = 0.6 * kExpected;
  std::size_t patch = 0;
  run_.change([&](PatchTree& tree) {
    if (patch++ == 0) split_all(tree, kSplits);
    set_even(tree, kExpected);
  });
  const std::uint64_t even = local_pass(whole);
  patch = 0;
  run_.change([&](PatchTree& tree) {
    for (Element& x : tree.elements)
      if (patch == 0 && !x.leaf()) x.detail = kVaries;
    ++patch;
  });
  EXPECT_GT(local_pass(whole), even + ((std::uint64_t{1} << kSplits) - 1) * whole.directions);
}

// A record that is not of this cluster's elements is refused, and nothing is changed.
TEST_F(FurnaceMended, WithoutItsMeasureThereIsNoMend) {
  run_.change([](PatchTree& tree) { set_even(tree, kExpected); });
  const std::vector<Spectrum> wrong(1, Spectrum{1});
  ASSERT_TRUE(run_.store()
                  .stream_out(record_id(RecordKind::kMend, 0), std::as_bytes(std::span(wrong)))
                  .ok());
  EXPECT_FALSE(put_in_mend(run_.store(), ClusterId(0u), *equilibrium_).ok());
  for (const double e : irradiance()) EXPECT_EQ(e, kExpected);
}

}  // namespace
}  // namespace atrium::testing
