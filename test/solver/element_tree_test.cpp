// Splitting: children partition their parent, keep their share of it, and end at contact lines.
#include "solver/element_tree.h"

#include <gtest/gtest.h>

#include <cstring>

#include "test/solver/shapes.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

PatchTree tree_of(const std::vector<Vec2>& outline, std::span<const Contact> contacts = {}) {
  Patches patches(2);
  return patches.tree(patches.add(in_plane(outline), {}, contacts));
}

double longer_extent(std::span<const Vec2> outline) {
  Vec2 lo = outline[0], hi = lo;
  for (const Vec2& p : outline) {
    lo = {std::min(lo.x, p.x), std::min(lo.y, p.y)};
    hi = {std::max(hi.x, p.x), std::max(hi.y, p.y)};
  }
  return std::max(hi.x - lo.x, hi.y - lo.y);
}

std::vector<std::int32_t> leaves(const PatchTree& tree) {
  std::vector<std::int32_t> found;
  for (std::size_t i = 0; i < tree.elements.size(); ++i)
    if (tree.elements[i].leaf()) found.push_back(static_cast<std::int32_t>(i));
  return found;
}

TEST(Plant, RootHasThePatchsAreaCentroidAndRadius) {
  Patches patches(2);
  const Polygon l = parallelogram({1, 2, 3}, {0, 3, 0}, {0, 0, 4});
  const PatchTree tree = patches.tree(patches.add(l, {Spectrum{.5, .25, .125}, Spectrum{1, 2, 3}}));
  ASSERT_EQ(tree.elements.size(), 1u);
  const Element& root = tree.elements[0];
  EXPECT_NEAR(root.area, 12, 1e-13);
  EXPECT_NEAR(tree.head.area, 12, 1e-13);
  EXPECT_NEAR(root.radius, 2.5, 1e-13);
  EXPECT_TRUE(root.leaf());
  EXPECT_EQ(root.parent, -1);
  const Vec3 c = tree.view().point(root.centroid);
  EXPECT_NEAR(length(c - Vec3(1, 3.5, 5)), 0, 1e-13);
  EXPECT_NEAR(length(tree.head.frame.n - Vec3(1, 0, 0)), 0, 1e-14);
  EXPECT_EQ(tree.head.reflectance, Spectrum(.5, .25, .125));
  EXPECT_EQ(tree.head.exitance, Spectrum(1, 2, 3));
  for (const double e : tree.e) EXPECT_EQ(e, 0);
}

TEST(SplitLeaf, ChildrenPartitionTheirParent) {
  std::mt19937 dice(7);
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    PatchTree tree = tree_of(shape.outline);
    grow(tree, 127);
    ASSERT_EQ(tree.elements.size(), 127u);
    const PatchView v = tree.view();
    for (const Element& x : tree.elements) {
      if (x.leaf()) continue;
      const Element &a = tree.elements[x.child], &b = tree.elements[x.child + 1];
      EXPECT_NEAR(a.area + b.area, x.area, 1e-12 * x.area + 1e-13 * x.radius * x.radius);
      EXPECT_NEAR(a.area, area2(v.polygon(a)), 1e-13 * x.radius * x.radius);
      // No overlap, no hole: a point of the parent lies in one child, or within rounding of both.
      const double rounding = 1e-11 * x.radius;
      for (int n = 0; n < 10; ++n) {
        const Vec2 p = point_of(v.polygon(x), dice);
        const bool deep_in_a = inside(v.polygon(a), p, -rounding);
        const bool deep_in_b = inside(v.polygon(b), p, -rounding);
        EXPECT_FALSE(deep_in_a && deep_in_b);
        EXPECT_TRUE(inside(v.polygon(a), p, rounding) || inside(v.polygon(b), p, rounding));
      }
    }
  }
}

TEST(SplitLeaf, ChildrenStandBehindTheirParentInPairs) {
  PatchTree tree = tree_of({{0, 0}, {3, 0}, {0, 2}});
  grow(tree, 63);
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    const Element& x = tree.elements[i];
    if (x.leaf()) continue;
    EXPECT_GT(x.child, static_cast<std::int32_t>(i));
    EXPECT_EQ(tree.elements[x.child].parent, static_cast<std::int32_t>(i));
    EXPECT_EQ(tree.elements[x.child + 1].parent, static_cast<std::int32_t>(i));
  }
}

// A tree grown breadth first has its places' order, as far as places are numbered; below, elements
// have the place that holds them.
TEST(SplitLeaf, PlacesAreNumberedAsInAHeap) {
  PatchTree tree = tree_of({{0, 0}, {3, 0}, {0, 2}});
  grow(tree, 511);
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    std::size_t place = i + 1;
    while (place >= 2 * kFirstDeepest) place /= 2;
    EXPECT_EQ(tree.elements[i].place, place);
  }
}

// Any line through the centroid of a convex figure leaves at least 4/9 on either side. [Winternitz]
TEST(SplitLeaf, CentroidCutsKeepFourNinths) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    PatchTree tree = tree_of(shape.outline);
    grow(tree, 255);
    for (const Element& x : tree.elements) {
      if (x.leaf()) continue;
      const double least = std::min(tree.elements[x.child].area, tree.elements[x.child + 1].area);
      EXPECT_GE(least, (4.0 / 9) * x.area * (1 - 1e-9) - 1e-13 * x.radius * x.radius);
    }
  }
}

TEST(SplitLeaf, RadiusHoldsTheElement) {
  for (const Shape& shape : shapes()) {
    PatchTree tree = tree_of(shape.outline);
    grow(tree, 63);
    for (const Element& x : tree.elements) {
      double farthest = 0;
      for (const Vec2& p : tree.view().polygon(x))
        farthest = std::max(farthest, std::hypot(p.x - x.centroid.x, p.y - x.centroid.y));
      EXPECT_NEAR(x.radius, farthest, 1e-12 * x.radius) << shape.name;
    }
  }
}

// A box of 1 m × 1 m stands in the middle of a floor of 4 m × 4 m. Once the contacts have been cut
// along, no element lies on both sides of one.
TEST(SplitLeaf, CutsAlongContactLines) {
  const std::vector<Vec2> foot{{1.3, 1.4}, {2.3, 1.4}, {2.3, 2.4}, {1.3, 2.4}};
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < 4; ++i)
    contacts.push_back({{foot[i].x, foot[i].y, 0}, {foot[(i + 1) % 4].x, foot[(i + 1) % 4].y, 0}});
  PatchTree tree = tree_of({{0, 0}, {4, 0}, {4, 4}, {0, 4}}, contacts);
  grow(tree, 511);
  const PatchView v = tree.view();
  // An element that the foot's outline crosses has a part of its area inside and a part outside.
  double crossed = 0;
  for (const std::int32_t i : leaves(tree)) {
    const std::span<const Vec2> outline = v.polygon(tree.elements[i]);
    bool in = false, out = false;
    for (const Vec2& p : outline) {
      // A little towards the centroid, so that shared edges do not count.
      const Vec3 x = v.point(p + 1e-6 * (tree.elements[i].centroid - p));
      const bool within = x.x > 1.3 && x.x < 2.3 && x.y > 1.4 && x.y < 2.4;
      (within ? in : out) = true;
    }
    if (in && out) crossed += tree.elements[i].area;
  }
  EXPECT_EQ(crossed, 0);
}

TEST(SplitLeaf, ContactThroughTheWholeElementIsItsFirstCut) {
  const std::vector<Contact> contacts{{{0, 0.7, 0}, {2, 0.9, 0}}};
  PatchTree tree = tree_of({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, contacts);
  ASSERT_TRUE(split_leaf(tree, 0, 0.01));
  // Below the line: a trapezoid of 2 m between 0.7 m and 0.9 m.
  const double below = 2 * (0.7 + 0.9) / 2;
  const double a = tree.elements[1].area, b = tree.elements[2].area;
  EXPECT_NEAR(std::min(a, b), below, 1e-12);
  EXPECT_NEAR(std::max(a, b), 4 - below, 1e-12);
}

TEST(SplitLeaf, ContactOutsideTheElementIsLeftAlone) {
  const std::vector<Contact> contacts{{{5, 0.5, 0}, {7, 0.5, 0}}};
  PatchTree with = tree_of({{0, 0}, {2, 0}, {2, 2}, {0, 2}}, contacts);
  PatchTree without = tree_of({{0, 0}, {2, 0}, {2, 2}, {0, 2}});
  grow(with, 31);
  grow(without, 31);
  ASSERT_EQ(with.elements.size(), without.elements.size());
  for (std::size_t i = 0; i < with.elements.size(); ++i)
    EXPECT_EQ(with.elements[i].area, without.elements[i].area);
}

// Of every shape, elements are split until none can be: no element is then shorter than min_edge,
// and none so long that its cut would leave halves as long: a centroid is at least a third of the
// extent from either end.
TEST(SplitLeaf, MinEdgeEndsSplitting) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.name);
    PatchTree tree = tree_of(shape.outline);
    const double min_edge = longer_extent(tree.view().polygon(tree.elements[0])) / 9;
    grow(tree, 100000, min_edge);
    for (const std::int32_t i : leaves(tree)) {
      const std::span<const Vec2> outline = tree.view().polygon(tree.elements[i]);
      EXPECT_LT(longer_extent(outline), 3 * min_edge);
      EXPECT_GE(longer_extent(outline), min_edge * (1 - 1e-9)) << "element " << i;
    }
  }
}

TEST(SplitLeaf, RefusedSplitChangesNothing) {
  PatchTree tree = tree_of({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  tree.e = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  const PatchTree before = tree;
  EXPECT_FALSE(split_leaf(tree, 0, 0.6));
  EXPECT_EQ(tree.elements.size(), before.elements.size());
  EXPECT_EQ(tree.vertices, before.vertices);
  EXPECT_EQ(tree.e, before.e);
  EXPECT_EQ(tree.basis, before.basis);
  EXPECT_TRUE(tree.elements[0].leaf());
}

TEST(SplitLeaf, SameBitsEveryTime) {
  for (const Shape& shape : shapes()) {
    PatchTree a = tree_of(shape.outline), b = tree_of(shape.outline);
    grow(a, 127);
    grow(b, 127);
    ASSERT_EQ(a.elements.size(), b.elements.size());
    EXPECT_EQ(
        0, std::memcmp(a.elements.data(), b.elements.data(), a.elements.size() * sizeof(Element)));
    EXPECT_EQ(a.vertices, b.vertices);
    EXPECT_EQ(a.basis, b.basis);
  }
}

// A doubling is exact in floating point, so that a tree of a model of 1e-6 m or 1e6 m differs from
// that of metres by its exponents alone.
TEST(SplitLeaf, ScalesByPowersOfTwoExactly) {
  for (const int exponent : {-20, 20}) {
    const double scale = std::ldexp(1.0, exponent);
    const std::vector<Vec2> outline{{0, 0}, {5, 1}, {4, 4}, {-1, 2}};
    PatchTree a = tree_of(outline), b = tree_of(moved(outline, scale, 0, {0, 0}));
    grow(a, 63);
    grow(b, 63);
    ASSERT_EQ(a.elements.size(), b.elements.size());
    for (std::size_t i = 0; i < a.elements.size(); ++i) {
      EXPECT_EQ(b.elements[i].area, a.elements[i].area * scale * scale);
      EXPECT_EQ(b.elements[i].radius, a.elements[i].radius * scale);
      EXPECT_EQ(b.elements[i].child, a.elements[i].child);
    }
    EXPECT_EQ(a.basis, b.basis);
  }
}

}  // namespace
}  // namespace atrium::testing
