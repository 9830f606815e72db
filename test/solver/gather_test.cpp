// Gathering across links made by hand, against the sum written out.
#include "solver/gather.h"

#include <gtest/gtest.h>

#include "test/solver/settings.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

// A source cluster of two patches; E of the second is a polynomial in two elements.
class Gather : public ::testing::Test {
 protected:
  static constexpr int kOrder = 2, kK = 3;

  Gather() : patches_(kOrder) {
    patches_.add(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {Spectrum{.5}, Spectrum{0}});
    patches_.add(parallelogram({0, 0, 2}, {0, 1, 0}, {1, 0, 0}),
                 {Spectrum{.2, .4, .8}, Spectrum{10, 20, 30}});
    trees_ = patches_.trees();
    grow(trees_[1], 3);
    for (std::size_t i = 0; i < trees_[1].e.size(); ++i) trees_[1].e[i] = 1.0 + i;
    record_.emplace(7, trees_);
    receiver_ = trees_[0];
    grow(receiver_, 3);
    slots_.reset(receiver_.elements.size(), kK);
  }

  // B of coefficient b, channel c, of an element of the second patch.
  double radiosity(std::size_t element, int b, int c) const {
    const PatchTree& t = trees_[1];
    return t.head.reflectance[c] * t.e[(element * kK + b) * kChannels + c] +
           (b == 0 ? t.head.exitance[c] : 0);
  }
  double slot(std::size_t element, int a, int c) const {
    return slots_.g[(element * kK + a) * kGatherChannels + c];
  }
  void run(const LinkSet& set, double cap) {
    const Braid braid = plait(ClusterId(7u), std::span(&set, 1));
    ASSERT_EQ(braid.strands.size(), 1u);
    gather(braid, braid.strands[0], {record_->view(), {}}, kOrder, receiver_.elements, cap, slots_,
           mean_, &details_);
  }

  Patches patches_;
  std::vector<PatchTree> trees_;
  std::optional<Record> record_;
  PatchTree receiver_;
  GatherSlots slots_;
  RowMean mean_;
  std::vector<SentDetail> details_;
};

TEST_F(Gather, LinkCarriesItsMatrixTimesRadiosity) {
  LinkSet set;
  set.links.push_back({{1, 1, 2}, 0});
  set.couplings = {.5f, .25f, -.125f, .0625f, .5f, 0, -.25f, 0, .125f};
  run(set, kNoCap);
  for (int a = 0; a < kK; ++a) {
    for (int c = 0; c < kChannels; ++c) {
      double expected = 0;
      for (int b = 0; b < kK; ++b) expected += set.couplings[a * kK + b] * radiosity(2, b, c);
      EXPECT_NEAR(slot(1, a, c), expected, 1e-12);
    }
    // Were every radiosity 1: the column of the source's mean.
    EXPECT_EQ(slot(1, a, kRowSum), set.couplings[a * kK]);
  }
  for (const std::size_t other : {0u, 2u})
    for (int a = 0; a < kK; ++a)
      for (int c = 0; c < kGatherChannels; ++c) EXPECT_EQ(slot(other, a, c), 0);
}

TEST_F(Gather, LinksToOneElementAddUp) {
  LinkSet one, two;
  one.links.push_back({{1, 1, 2}, 0});
  one.couplings = {.5f, .25f, -.125f, .0625f, .5f, 0, -.25f, 0, .125f};
  run(one, kNoCap);
  const std::vector<double> once = slots_.g;
  slots_.reset(receiver_.elements.size(), kK);
  two = one;
  two.links.push_back(one.links[0]);
  two.couplings.insert(two.couplings.end(), one.couplings.begin(), one.couplings.end());
  run(two, kNoCap);
  for (std::size_t i = 0; i < once.size(); ++i) EXPECT_DOUBLE_EQ(slots_.g[i], 2 * once[i]);
}

TEST_F(Gather, ThinLinkCarriesMeansOnly) {
  LinkSet set;
  set.thin.push_back({{2, 1, 1}, 0.25f});
  run(set, kNoCap);
  for (int c = 0; c < kChannels; ++c) EXPECT_NEAR(slot(2, 0, c), 0.25 * radiosity(1, 0, c), 1e-12);
  EXPECT_EQ(slot(2, 0, kRowSum), 0.25);
  for (int a = 1; a < kK; ++a)
    for (int c = 0; c < kGatherChannels; ++c) EXPECT_EQ(slot(2, a, c), 0);
}

// What came is noted by source patch, in runs: form factors times area, what they brought, and what
// of the source's light its element leaves out.
TEST_F(Gather, WhatLinksBringOfASourceIsNoted) {
  trees_[1].head.escape = 0;  // closed: all that it sends arrives
  trees_[1].elements[1].detail = 6;
  record_.emplace(7, trees_);
  LinkSet set;
  set.thin.push_back({{2, 1, 1}, 0.25f});
  set.thin.push_back({{1, 1, 2}, 0.5f});
  run(set, kNoCap);
  const auto light = [&](std::size_t element) {
    return luminance(
        {radiosity(element, 0, 0), radiosity(element, 0, 1), radiosity(element, 0, 2)});
  };
  const double f1 = .25 * receiver_.elements[2].area, f2 = .5 * receiver_.elements[1].area;
  ASSERT_EQ(details_.size(), 1u);
  EXPECT_EQ(details_[0].source_patch, 1u);
  EXPECT_NEAR(details_[0].factors, f1 + f2, 1e-12);
  EXPECT_NEAR(details_[0].sent, f1 * light(1) + f2 * light(2), 1e-12);
  EXPECT_NEAR(details_[0].left_out, f1 * luminance(trees_[1].head.reflectance) * 6, 1e-12);
}

// A share of it is brought along, in the colour of the rest; nothing of what leaves the scene.
TEST_F(Gather, AShareOfTheDetailLeftOutIsBroughtAlong) {
  trees_[1].elements[1].detail = 6;
  LinkSet set;
  set.thin.push_back({{2, 1, 1}, 0.25f});
  const Braid braid = plait(ClusterId(7u), std::span(&set, 1));
  const std::vector<double> share{0, .5};
  const double bright = luminance({radiosity(1, 0, 0), radiosity(1, 0, 1), radiosity(1, 0, 2)});
  for (const double escape : {0.0, 0.25}) {
    trees_[1].head.escape = escape;
    record_.emplace(7, trees_);
    slots_.reset(receiver_.elements.size(), kK);
    gather(braid, braid.strands[0], {record_->view(), {}, share}, kOrder, receiver_.elements,
           kNoCap, slots_, mean_, &details_);
    const double more = escape > 0 ? 0 : .5 * luminance(trees_[1].head.reflectance) * 6;
    for (int c = 0; c < kChannels; ++c)
      EXPECT_NEAR(slot(2, 0, c), .25 * radiosity(1, 0, c) * (1 + more / bright), 1e-12);
  }
}

// Light that is pending of the second patch's halves, 1 and 2 lx, and 1.5 of all of it: it is
// reflected like E.
TEST_F(Gather, WhatIsPendingOfAPlaceIsReadWithItsElements) {
  LinkSet set;
  set.thin = {{{2, 1, 0}, 0.25f}, {{2, 1, 1}, 0.125f}, {{2, 1, 2}, 0.5f}};
  const Braid braid = plait(ClusterId(7u), std::span(&set, 1));
  PlacedLight pending;
  pending.add_patch(Spectrum{100});
  const std::vector<Spectrum> by_place{Spectrum{0}, Spectrum{1.5}, Spectrum{1}, Spectrum{2}};
  pending.add_patch(by_place[1], by_place);
  gather(braid, braid.strands[0], {record_->view(), pending}, kOrder, receiver_.elements, kNoCap,
         slots_, mean_, nullptr);
  for (int c = 0; c < kChannels; ++c) {
    const double b = .25 * radiosity(0, 0, c) + .125 * radiosity(1, 0, c) + .5 * radiosity(2, 0, c);
    const double more = .25 * 1.5 + .125 * 1 + .5 * 2;
    EXPECT_NEAR(slot(2, 0, c), b + trees_[1].head.reflectance[c] * more, 1e-12);
  }
}

// Strands of a braid are the sets of its receiver's patches, those without links left out.
TEST_F(Gather, PlaitedSetsAreTheStrands) {
  LinkSet none, thin, both;
  thin.thin.push_back({{2, 1, 1}, 0.25f});
  both.links.push_back({{1, 1, 2}, 0});
  both.couplings = {.5f, .25f, -.125f, .0625f, .5f, 0, -.25f, 0, .125f};
  both.thin.push_back({{0, 1, 1}, 0.125f});
  const std::vector<LinkSet> sets{none, both, none, thin, both};
  const Braid braid = plait(ClusterId(7u), sets);
  EXPECT_EQ(braid.source, ClusterId(7u));
  EXPECT_EQ(braid.count(), 5u);
  ASSERT_EQ(braid.strands.size(), 3u);
  const std::uint32_t patches[] = {1, 3, 4};
  for (std::size_t i = 0; i < 3; ++i) {
    const Braid::Strand& s = braid.strands[i];
    EXPECT_EQ(s.patch, patches[i]);
    EXPECT_EQ(s.links, sets[s.patch].links.size());
    EXPECT_EQ(s.thin, sets[s.patch].thin.size());
  }
  // Each strand gathers what its set alone does.
  for (std::size_t i = 0; i < 3; ++i) {
    slots_.reset(receiver_.elements.size(), kK);
    run(sets[patches[i]], kNoCap);
    const std::vector<double> alone = slots_.g;
    slots_.reset(receiver_.elements.size(), kK);
    gather(braid, braid.strands[i], {record_->view(), {}}, kOrder, receiver_.elements, kNoCap,
           slots_, mean_, &details_);
    EXPECT_EQ(slots_.g, alone);
  }
}

// What closes a row is the light of what is in doubt, by its doubt, each at the element that it is
// of; a source above the cap counts with its colour but not with its brightness.
TEST_F(Gather, DoubtsAreOfTheirElementsAndCapped) {
  LinkSet set;
  set.links.push_back({{1, 1, 2}, 0.5f});
  set.couplings.assign(kK * kK, 0);
  set.thin.push_back({{2, 1, 0}, 0.75f});
  set.doubts.push_back({{2, 1, 1}, 0.25f});
  const auto b1 = [&](std::size_t element) {
    return Spectrum{radiosity(element, 0, 0), radiosity(element, 0, 1), radiosity(element, 0, 2)};
  };
  const double thin = 2.0 / 9 * .75 * .75;  // one segment got through of one
  // As much of it as counts.
  const auto capped = [](const Spectrum& b, double cap) {
    return b * std::min(1.0, cap / luminance(b));
  };
  for (const double cap : {kNoCap, 0.5 * luminance(b1(2))}) {
    slots_.reset(receiver_.elements.size(), kK);
    mean_ = {};
    run(set, cap);
    const Spectrum one = .5 * capped(b1(2), cap);
    const Spectrum two = thin * capped(b1(0), cap) + .25 * capped(b1(1), cap);
    const double area1 = receiver_.elements[1].area, area2 = receiver_.elements[2].area;
    EXPECT_EQ(slots_.doubts[0].weight, 0);
    EXPECT_EQ(slots_.doubts[1].weight, .5);
    EXPECT_NEAR(slots_.doubts[2].weight, thin + .25, 1e-12);
    EXPECT_NEAR(mean_.doubts.weight, area1 * .5 + area2 * (thin + .25), 1e-12);
    for (int c = 0; c < kChannels; ++c) {
      EXPECT_NEAR(slots_.doubts[1].light[c], one[c], 1e-12);
      EXPECT_NEAR(slots_.doubts[2].light[c], two[c], 1e-12);
      EXPECT_NEAR(mean_.doubts.light[c], area1 * one[c] + area2 * two[c], 1e-12);
    }
  }
}

}  // namespace
}  // namespace atrium::testing
