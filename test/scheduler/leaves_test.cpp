// Points find their leaves: a leaf is convex, so that its centroid is its own.
#include "scheduler/leaves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "scheduler/stored_patches.h"
#include "test/physics/rooms.h"
#include "test/scheduler/solved_store.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kArena = std::size_t{32} << 20;

// What is to be found: each leaf's centroid, twice, numbered by the leaf, and the last leaf first.
std::vector<Landing> centroids(const PatchView& patch) {
  std::vector<Landing> all;
  for (std::size_t i = patch.elements.size(); i-- > 0;)
    if (patch.elements[i].leaf())
      all.insert(all.end(), 2,
                 {patch.elements[i].centroid, static_cast<std::uint32_t>(i)});
  return all;
}

class Leaves : public ::testing::Test {
 protected:
  // Calls `visit` with every patch of an L-shaped room, whose trees are deep and uneven.
  template <class Visit>
  void each_patch(const Visit& visit) {
    Bench bench(generated({.kind = "furnace", .rho = 0.5, .exitance = 100, .shape = "l-room"}));
    SolvedStore run(solved(bench, 0.02), kArena);
    std::size_t most = 0;
    for (std::size_t c = 0; c < run.model().clusters.size(); ++c)
      ASSERT_TRUE(each_receiver(run.store(), ClusterId(c), [&](const PatchView& patch) {
                    most = std::max(most, patch.elements.size());
                    visit(patch);
                  }).ok());
    EXPECT_GE(most, 7u) << "no tree is deeper than a cut or two";
  }
};

TEST_F(Leaves, HoldTheirCentroids) {
  each_patch([](const PatchView& patch) {
    for (const Landing& at : centroids(patch))
      EXPECT_EQ(leaf_at(patch, at.p), static_cast<std::int32_t>(at.number));
  });
}

TEST_F(Leaves, AreVisitedOnceWithAllThatTheyHold) {
  each_patch([](const PatchView& patch) {
    std::vector<Landing> landings = centroids(patch);
    std::vector<int> held(patch.elements.size(), 0);
    each_leaf(patch, landings, [&](std::int32_t leaf, std::span<const Landing> here) {
      EXPECT_EQ(here.size(), 2u);
      for (const Landing& at : here) EXPECT_EQ(at.number, static_cast<std::uint32_t>(leaf));
      ++held[static_cast<std::size_t>(leaf)];
    });
    for (std::size_t i = 0; i < held.size(); ++i)
      EXPECT_EQ(held[i], patch.elements[i].leaf() ? 1 : 0);
  });
}

TEST_F(Leaves, NobodyIsVisitedWithNothing) {
  each_patch([](const PatchView& patch) {
    each_leaf(patch, std::span<Landing>(), [](std::int32_t, std::span<const Landing>) { FAIL(); });
  });
}

}  // namespace
}  // namespace atrium::testing
