// Branches: a tree refined branch by branch is the tree refined whole.
#include "solver/branch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "solver/refine.h"
#include "test/solver/settings.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

// A floor, a lamp over it, a table between; the floor's tree has this many elements beforehand.
struct LitFloor {
  Patches patches;
  std::vector<PatchTree> sources;
  std::vector<BlockerPolygon> blockers;
  PatchTree tree;

  explicit LitFloor(std::size_t elements) {
    const Polygon floor = parallelogram({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
    const Polygon lamp = parallelogram({1, 1, 2}, {0, 2, 0}, {2, 0, 0});
    const Polygon table = parallelogram({1, 1, 0.7}, {1, 0, 0}, {0, 1.5, 0});
    tree = patches.tree(patches.add(floor));
    sources.push_back(patches.tree(patches.add(lamp, {Spectrum{0}, Spectrum{1}})));
    sources.push_back(patches.tree(patches.add(table, {Spectrum{0.5}, Spectrum{0}})));
    for (const Polygon& p : {floor, lamp, table})
      blockers.push_back({p, static_cast<std::uint32_t>(blockers.size())});
    grow(tree, elements);
  }
};

// Of a link, what does not depend on the order in which elements were appended.
using Named = std::tuple<double, double, double, std::uint32_t, std::uint32_t, float>;

struct Linked {
  PatchTree tree;
  std::vector<Named> links;
  double doubt = 0;
};

Linked collect(const PatchTree& tree, const LinkSet& set) {
  Linked linked{tree, {}, 0};
  const auto add = [&](const Ends& l, float coupling) {
    const Element& x = tree.elements[l.receiver];
    linked.links.emplace_back(x.centroid.x, x.centroid.y, x.area, l.source_patch, l.source,
                              coupling);
  };
  const int k = tree.view().k();
  for (std::size_t i = 0; i < set.links.size(); ++i)
    add(set.links[i].ends, set.couplings[i * k * k]);
  for (const ThinLink& l : set.thin) add(l.ends, l.coupling);
  for (const Doubt& d : set.doubts)
    linked.doubt += d.doubt * tree.elements[d.ends.receiver].area;
  std::ranges::sort(linked.links);
  return linked;
}

Linked link(const LitFloor& lit, bool by_branches) {
  std::vector<PatchTree> sources = lit.sources;
  const Record record(0, sources);
  const SourceRoots roots(record.view());
  const BlockerIndex index(lit.blockers);
  const RayScene rays(lit.blockers);
  Refiner refiner(settings_of(0.001), {&index, &rays});
  PatchTree tree = lit.tree;
  LinkSet set;
  if (!by_branches) {
    refiner.link(tree, roots, set);
    refiner.flush();
    return collect(tree, set);
  }
  std::vector<Branch> branches = cut_branches(tree);
  EXPECT_GT(branches.size(), 1u);
  std::vector<LinkSet> sets(branches.size());
  for (std::size_t b = 0; b < branches.size(); ++b) refiner.link(branches[b], roots, sets[b]);
  refiner.flush();
  for (std::size_t b = 0; b < branches.size(); ++b) {
    graft(tree, branches[b], std::span(sets).subspan(b, 1));
    set.append(sets[b]);
  }
  return collect(tree, set);
}

// The elements of two trees by place: what hangs below what, and the light on each.
std::vector<std::tuple<double, double, double, double, double>> by_place(const PatchTree& tree) {
  std::vector<std::tuple<double, double, double, double, double>> all;
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    const Element& x = tree.elements[i];
    const double above = x.parent < 0 ? 0 : tree.elements[x.parent].area;
    all.emplace_back(x.centroid.x, x.centroid.y, x.area, above, tree.view().e_of(i)[0]);
  }
  std::ranges::sort(all);
  return all;
}

TEST(Branch, GraftedBranchesAreTheTreeRefinedWhole) {
  for (const std::size_t elements : {400, 1500}) {
    const LitFloor lit(elements);
    const Linked whole = link(lit, false), grafted = link(lit, true);
    EXPECT_GT(whole.tree.elements.size(), elements);  // something was appended
    EXPECT_EQ(by_place(whole.tree), by_place(grafted.tree));
    EXPECT_EQ(whole.links, grafted.links);
    EXPECT_NEAR(whole.doubt, grafted.doubt, 1e-6 * whole.doubt);
  }
}

TEST(Branch, EveryElementIsBelowOneFoot) {
  const LitFloor lit(700);
  const std::vector<Branch> branches = cut_branches(lit.tree);
  std::vector<int> held(lit.tree.elements.size(), 0);
  double area = 0;
  for (const Branch& b : branches) {
    area += b.tree.elements[b.foot].area;
    for (std::size_t i = 0; i < b.origin.size(); ++i) {
      const bool own = i >= b.stumps.size() || b.stumps[i] == Branch::Stump::kOwn;
      held[b.origin[i]] += own;
      EXPECT_EQ(lit.tree.elements[b.origin[i]].area, b.tree.elements[i].area);
    }
  }
  EXPECT_NEAR(area, lit.tree.head.area, 1e-12 * lit.tree.head.area);
  std::size_t above = 0;
  for (const int n : held) {
    EXPECT_LE(n, 1);
    above += n == 0;
  }
  EXPECT_EQ(above, branches.size() - 1);  // a binary tree's inner nodes
}

TEST(Branch, ASmallTreeStaysWhole) {
  EXPECT_TRUE(cut_branches(LitFloor(1).tree).empty());
  EXPECT_TRUE(cut_branches(LitFloor(63).tree).empty());
}

}  // namespace
}  // namespace atrium::testing
