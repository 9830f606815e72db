// The record of a cluster: what goes in comes out, bit for bit, and what is cut short is refused.
#include "engine/cluster_record.h"

#include <gtest/gtest.h>

#include <cstring>

#include "test/solver/shapes.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

// All shapes of the tests, each grown to a size of its own, with E at random and a contact each.
std::vector<PatchTree> many_trees(int order) {
  std::mt19937 dice(11);
  std::uniform_real_distribution<double> number(0, 1000);
  Patches patches(order);
  const std::vector<Contact> contact{{{0.1, 0.2, 0}, {0.3, 0.2, 0}}};
  for (const Shape& s : shapes())
    patches.add(in_plane(s.outline), {Spectrum{.1, .2, .3}, Spectrum{4, 5, 6}}, contact);
  std::vector<PatchTree> trees = patches.trees();
  for (std::size_t t = 0; t < trees.size(); ++t) {
    grow(trees[t], 1 + 4 * t);
    for (double& e : trees[t].e) e = number(dice);
    for (Element& x : trees[t].elements) x.detail = number(dice);
    trees[t].head.escape = 0.25;
  }
  return trees;
}

void expect_equal(const PatchTree& a, const PatchTree& b) {
  EXPECT_EQ(0, std::memcmp(&a.head, &b.head, sizeof a.head));
  ASSERT_EQ(a.elements.size(), b.elements.size());
  EXPECT_EQ(0,
            std::memcmp(a.elements.data(), b.elements.data(), a.elements.size() * sizeof(Element)));
  EXPECT_EQ(a.order, b.order);
  EXPECT_EQ(a.vertices, b.vertices);
  ASSERT_EQ(a.contacts.size(), b.contacts.size());
  for (std::size_t i = 0; i < a.contacts.size(); ++i) {
    EXPECT_EQ(a.contacts[i].a, b.contacts[i].a);
    EXPECT_EQ(a.contacts[i].b, b.contacts[i].b);
  }
  EXPECT_EQ(a.e, b.e);
  EXPECT_EQ(a.basis, b.basis);
}

TEST(ClusterRecord, RoundTripKeepsEveryBit) {
  for (const int order : {1, 2, 3}) {
    std::vector<PatchTree> trees = many_trees(order);
    const Record record(42, trees);
    const ClusterView view = record.view();
    EXPECT_EQ(view.head().cluster, 42u);
    EXPECT_EQ(view.head().order, static_cast<std::uint32_t>(order));
    ASSERT_EQ(view.size(), trees.size());
    std::vector<PatchTree> back = read_record(view);
    for (std::size_t t = 0; t < trees.size(); ++t) expect_equal(back[t], trees[t]);
    const Record again(42, back);
    ASSERT_EQ(again.bytes().size(), record.bytes().size());
    EXPECT_EQ(0, std::memcmp(again.bytes().data(), record.bytes().data(), record.bytes().size()));
  }
}

TEST(ClusterRecord, ViewsOfPatchesAreThoseOfTheirTrees) {
  std::vector<PatchTree> trees = many_trees(2);
  const Record record(0, trees);
  const ClusterView view = record.view();
  for (std::size_t t = 0; t < trees.size(); ++t) {
    const PatchView a = view.patch(t), b = trees[t].view();
    ASSERT_EQ(a.elements.size(), b.elements.size());
    for (std::size_t i = 0; i < a.elements.size(); ++i) {
      EXPECT_TRUE(std::ranges::equal(a.e_of(i), b.e_of(i)));
      EXPECT_TRUE(std::ranges::equal(a.basis_of(i), b.basis_of(i)));
      EXPECT_TRUE(std::ranges::equal(a.polygon(a.elements[i]), b.polygon(b.elements[i])));
    }
  }
}

TEST(ClusterRecord, BoundsHoldThePatches) {
  Patches patches(2);
  patches.add(parallelogram({1, 2, 3}, {4, 0, 0}, {0, 5, 0}));
  patches.add(parallelogram({1, 2, 3}, {0, 5, 0}, {0, 0, 6}));
  std::vector<PatchTree> trees = patches.trees();
  const Record record(0, trees);
  const Box b = record.view().head().bounds;
  EXPECT_NEAR(length(b.lo - Vec3(1, 2, 3)), 0, 1e-14);
  EXPECT_NEAR(length(b.hi - Vec3(5, 7, 9)), 0, 1e-14);
}

TEST(ClusterRecord, RefusedAtEveryShorterLength) {
  std::vector<PatchTree> trees = many_trees(2);
  const Record record(1, trees);
  for (std::size_t n = 0; n < record.bytes().size(); ++n) {
    const Result<ClusterView> view = ClusterView::parse(record.bytes().first(n));
    ASSERT_FALSE(view.ok()) << n << " of " << record.bytes().size() << " bytes";
    EXPECT_EQ(view.status().code(), Code::kStore);
  }
}

TEST(ClusterRecord, RefusedWhereItIsNotAligned) {
  std::vector<PatchTree> trees = many_trees(1);
  const Record record(1, trees);
  std::vector<std::byte> shifted(4);
  shifted.insert(shifted.end(), record.bytes().begin(), record.bytes().end());
  EXPECT_FALSE(ClusterView::parse(std::span(shifted).subspan(4, record.bytes().size())).ok());
}

TEST(ClusterRecord, RefusedWhereCountsAreWrong) {
  std::vector<PatchTree> trees = many_trees(2);
  const Record record(1, trees);
  const auto broken = [&](auto change) {
    std::vector<std::byte> bytes(record.bytes().begin(), record.bytes().end());
    change(bytes);
    return !ClusterView::parse(bytes).ok();
  };
  const auto head = [](std::vector<std::byte>& b) {
    return reinterpret_cast<ClusterHead*>(b.data());
  };
  const auto patch = [](std::vector<std::byte>& b) {
    return reinterpret_cast<PatchHead*>(b.data() + sizeof(ClusterHead));
  };
  constexpr std::uint32_t kHuge = 0xffffffff;
  EXPECT_TRUE(broken([&](auto& b) { head(b)->order = 0; }));
  EXPECT_TRUE(broken([&](auto& b) { head(b)->order = kMaxOrder + 1; }));
  EXPECT_TRUE(broken([&](auto& b) { head(b)->elements = kHuge; }));
  EXPECT_TRUE(broken([&](auto& b) { head(b)->patches = kHuge; }));
  EXPECT_TRUE(broken([&](auto& b) { patch(b)->first_element = kHuge; }));
  EXPECT_TRUE(broken([&](auto& b) { patch(b)->element_count = kHuge; }));
  EXPECT_TRUE(broken([&](auto& b) { patch(b)->element_count = 0; }));
  EXPECT_TRUE(broken([&](auto& b) { patch(b)->vertex_count = kHuge; }));
  EXPECT_TRUE(broken([&](auto& b) { patch(b)->contact_count = kHuge; }));
}

}  // namespace
}  // namespace atrium::testing
