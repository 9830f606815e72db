// Light that comes beside gathers: to a whole patch, and to its leaves.
#include "scheduler/relight.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>

#include "test/pagestore/simulated_disk.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

constexpr double kRounding = 1e-13;  // relative to light of about 1
constexpr Spectrum kNone{0};

std::size_t stride(const PatchTree& tree) { return std::size_t(tree.view().k()) * kChannels; }

PlacedLight everywhere(const Spectrum& light) {
  PlacedLight placed;
  placed.add_patch(light);
  return placed;
}

// A unit square of eight leaves, its E on them at random, about 10, and their means above.
PatchTree lit_square(std::mt19937& dice) {
  Patches patches;
  PatchTree tree = patches.tree(patches.add(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0})));
  grow(tree, 15);
  std::uniform_real_distribution<double> number(-1, 1);
  for (std::size_t n = 0; n < tree.e.size(); ++n)
    tree.e[n] = number(dice) + (n % stride(tree) < kChannels ? 10 : 0);
  relight(tree, everywhere(kNone), 0, {});
  return tree;
}

// To each coefficient of each leaf, at random.
std::vector<Spectrum> random_mends(const PatchTree& tree, std::mt19937& dice) {
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Spectrum> mends;
  for (const Element& e : tree.elements)
    for (int a = 0; e.leaf() && a < tree.view().k(); ++a)
      mends.push_back({number(dice), number(dice), number(dice)});
  return mends;
}

TEST(Relight, WhatComesToAllOfAPatchIsAddedToEveryMeanAndToNothingElse) {
  std::mt19937 dice(1);
  PatchTree tree = lit_square(dice);
  const std::vector<double> before = tree.e;
  const Spectrum more{1, -2, 3};
  const PushPullSums sums = relight(tree, everywhere(more), 0, {});
  for (std::size_t n = 0; n < before.size(); ++n) {
    const std::size_t of = n % stride(tree);
    EXPECT_NEAR(tree.e[n], before[n] + (of < kChannels ? more[int(of)] : 0), 20 * kRounding);
  }
  EXPECT_EQ(sums.gained, kNone);
}

// Of four places, the light of which is given for them, their means above them: eight leaves have
// their place's, two to a place, and so have those between. The root has the mean of all, 2.5.
TEST(Relight, WhatComesToPlacesOfAPatchIsAddedWhereTheyAre) {
  std::mt19937 dice(5);
  PatchTree tree = lit_square(dice);
  const std::vector<double> before = tree.e;
  PlacedLight more;
  const std::vector<Spectrum> by_place{kNone,       Spectrum{2.5}, Spectrum{1.5}, Spectrum{3.5},
                                       Spectrum{1}, Spectrum{2},   Spectrum{3},   Spectrum{4}};
  more.add_patch(by_place[1], by_place);
  std::vector<PlaceGain> gains(by_place.size());
  relight(tree, more, 0, {}, gains);
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    std::size_t q = i;  // of a tree that was grown breadth first
    while (q > 6) q = std::size_t(tree.elements[q].parent);
    EXPECT_EQ(place_among(8, tree.elements[i].place), q + 1);
    EXPECT_NEAR(tree.e[i * stride(tree)], before[i * stride(tree)] + by_place[q + 1].x,
                20 * kRounding);
  }
  for (std::size_t q = 0; q < gains.size(); ++q) {
    EXPECT_NEAR(gains[q].area, q < 4 ? 0 : 0.25, kRounding);
    EXPECT_EQ(gains[q].gained, kNone);
  }
}

// The patch is 1 m², so what it gains is the mean of the mends' first coefficients by area, and so
// much brighter its root's mean becomes.
TEST(Relight, MendsAreAddedLeafByLeafAndAreWhatIsGained) {
  std::mt19937 dice(2);
  PatchTree tree = lit_square(dice);
  const std::vector<double> before = tree.e;
  const std::vector<Spectrum> mends = random_mends(tree, dice);
  const Spectrum more{0.5};
  const PushPullSums sums = relight(tree, everywhere(more), 0, mends);
  Spectrum gained{0};
  std::size_t at = 0;
  const int k = tree.view().k();
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    if (!tree.elements[i].leaf()) continue;
    gained += tree.elements[i].area * mends[at];
    for (int a = 0; a < k; ++a, ++at)
      for (int c = 0; c < kChannels; ++c) {
        const std::size_t n = i * stride(tree) + std::size_t(a * kChannels + c);
        EXPECT_NEAR(tree.e[n], before[n] + (a == 0 ? more[c] : 0) + mends[at][c], 20 * kRounding);
      }
  }
  ASSERT_EQ(at, mends.size());
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(sums.gained[c], gained[c], 20 * kRounding);
    EXPECT_NEAR(tree.e[std::size_t(c)], before[std::size_t(c)] + more[c] + gained[c],
                20 * kRounding);
  }
}

// Of a leaf whose red mean would fall below 0 all red is gone, its slopes too; green stays.
TEST(Relight, LightDoesNotBecomeNegative) {
  std::mt19937 dice(3);
  PatchTree tree = lit_square(dice);
  const std::vector<double> before = tree.e;
  std::size_t leaf = 0;
  while (!tree.elements[leaf].leaf()) ++leaf;
  std::vector<Spectrum> mends(random_mends(tree, dice).size(), kNone);
  mends[0] = {-100, 0, 0};
  relight(tree, everywhere(kNone), 0, mends);
  for (std::size_t n = leaf * stride(tree); n < (leaf + 1) * stride(tree); ++n)
    EXPECT_EQ(tree.e[n], n % kChannels == 0 ? 0 : before[n]);
}

// A cluster of an inert patch between two that are lit: it has no mends, and stays dark.
TEST(Relight, InertPatchesTakeNoPart) {
  SimulatedDisk disk;
  auto store = ClusterStore::create("run", {.arena_bytes = std::uint64_t{1} << 20, .disk = &disk});
  ASSERT_TRUE(store.ok()) << store.status().message();
  std::mt19937 dice(4);
  std::vector<PatchTree> trees(3, lit_square(dice));
  trees[1].head.inert = true;
  trees[1].e.assign(trees[1].e.size(), 0);
  const Record record(7, trees);
  EXPECT_EQ(mend_count(record.view()), 2 * random_mends(trees[0], dice).size());

  const RecordId id = record_id(RecordKind::kCluster, 7);
  ASSERT_TRUE((*store)->create_record(id, record.bytes()).ok());
  std::vector<Spectrum> mends(mend_count(record.view()), kNone);
  mends.back() = {0, 0, 1};
  mends[mends.size() / 2] = {0, 1, 0};  // the first leaf's mean in the last patch
  {
    auto edit = (*store)->edit(id);
    ASSERT_TRUE(edit.ok());
    PlacedLight more;
    for (const double red : {1, 5, 2}) more.add_patch({red, 0, 0});
    const Relit relit = relight(ClusterView::parse(edit->bytes()).value(), *edit, more, mends);
    EXPECT_EQ(relit.elements, 3 * trees[0].elements.size());
    EXPECT_EQ(relit.gains[0].gained, kNone);
    EXPECT_EQ(relit.gains[1].gained, kNone);
    EXPECT_GT(relit.gains[2].gained.y, 0);
    EXPECT_EQ(relit.gains[2].gained.x, 0);
  }
  const auto pin = (*store)->read(id);
  ASSERT_TRUE(pin.ok());
  const std::vector<PatchTree> after = read_record(ClusterView::parse(pin->bytes()).value());
  EXPECT_NEAR(after[0].e[0], trees[0].e[0] + 1, 20 * kRounding);
  EXPECT_EQ(after[1].e, trees[1].e);
  EXPECT_NEAR(after[2].e[0], trees[2].e[0] + 2, 20 * kRounding);
}

}  // namespace
}  // namespace atrium::testing
