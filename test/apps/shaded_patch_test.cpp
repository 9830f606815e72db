#include "apps/picture/shaded_patch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solver/basis.h"
#include "test/solver/trees.h"

namespace atrium {
namespace {

constexpr int kOrder = 2;

// A square of 2 m whose tree is split at random, finer towards nowhere in particular.
PatchTree random_tree(testing::Patches& patches, int splits, std::uint32_t seed) {
  const Polygon square{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  testing::Paint paint;
  paint.reflectance = Spectrum(0.5);
  PatchTree tree = patches.tree(patches.add(square, paint));
  std::mt19937 random(seed);
  for (int i = 0; i < splits; ++i) {
    std::vector<std::int32_t> leaves;
    for (std::size_t e = 0; e < tree.elements.size(); ++e)
      if (tree.elements[e].leaf()) leaves.push_back(static_cast<std::int32_t>(e));
    split_leaf(tree, leaves[random() % leaves.size()], 1e-3);
  }
  return tree;
}

// The only patch of a cluster that holds the tree.
ShadedPatch shaded_alone(PatchTree tree) {
  std::vector<PatchTree> trees{std::move(tree)};
  const testing::Record record(0, trees);
  return shade(record.view(), 1e-7).front();
}

void shake(PatchTree& tree, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> light(50, 150), slope(-10, 10);
  const int k = coefficient_count(kOrder) * kChannels;
  for (std::size_t i = 0; i < tree.e.size(); ++i)
    tree.e[i] = int(i) % k < kChannels ? light(random) : slope(random);
}

double area2(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Vertices of the finer side are on the coarser face's outline: both sides see the same colours.
TEST(ShadedPatch, NoCrackBetweenFacesOfAnySize) {
  testing::Patches patches(kOrder);
  PatchTree tree = random_tree(patches, 60, 1);
  shake(tree, 2);
  const ShadedPatch shaded = shaded_alone(tree);
  int compared = 0;
  for (const ShadedFace& face : shaded.faces) {
    const auto outline = shaded.outline_of(face);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vec2 a = shaded.corners[outline[i]].p;
      const Vec2 b = shaded.corners[outline[(i + 1) % outline.size()]].p;
      const Vec2 outward = normalize(Vec2(b.y - a.y, a.x - b.x));
      for (const double t : {0.1, 0.5, 0.9}) {
        const Vec2 p = a + t * (b - a), over = p + 1e-9 * outward;
        if (std::max(std::abs(over.x - 1), std::abs(over.y - 1)) > 1) continue;  // off the patch
        // The frame's origin is the patch's own: go by faces that hold the point.
        const ShadedFace& other = shaded.faces[face_at(shaded, over)];
        if (&other == &face) continue;
        const double here = radiosity_at(shaded, face, p).x;
        EXPECT_NEAR(radiosity_at(shaded, other, p).x, here, 1e-5 * here);
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 100);
}

// E linear over the whole patch: averages at corners and mean value coordinates leave it as it is.
TEST(ShadedPatch, LinearLightStaysLinear) {
  testing::Patches patches(kOrder);
  const Polygon square{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  testing::Paint paint;
  paint.reflectance = Spectrum(0.5);
  paint.exitance = Spectrum(10);
  PatchTree tree = patches.tree(patches.add(square, paint));
  for (int c = 0; c < kChannels; ++c) {
    tree.e[std::size_t(c)] = 100;
    tree.e[std::size_t(kChannels + c)] = 20;
    tree.e[std::size_t(2 * kChannels + c)] = -30;
  }
  const PatchTree root = tree;
  std::mt19937 random(3);
  for (int i = 0; i < 40; ++i) {
    std::int32_t leaf = 0;
    while (!tree.elements[std::size_t(leaf)].leaf())
      leaf = tree.elements[std::size_t(leaf)].child + static_cast<std::int32_t>(random() % 2);
    split_leaf(tree, leaf, 1e-3);
  }
  const ShadedPatch shaded = shaded_alone(tree);
  ASSERT_GT(shaded.faces.size(), 20u);
  std::uniform_real_distribution<double> place(0, 2);
  for (int i = 0; i < 200; ++i) {
    const Vec2 p = shaded.frame.to_plane({place(random), place(random), 0});
    const BasisValues phi = evaluate_basis(root.basis, root.elements[0], kOrder, p);
    const double e = 100 * phi[0] + 20 * phi[1] - 30 * phi[2];
    const ShadedFace& face = shaded.faces[face_at(shaded, p)];
    EXPECT_NEAR(radiosity_at(shaded, face, p).x, 10 + 0.5 * e, 1e-9);
  }
}

TEST(ShadedPatch, TrianglesCoverThePatchOnce) {
  testing::Patches patches(kOrder);
  PatchTree tree = random_tree(patches, 80, 4);
  shake(tree, 5);
  const ShadedPatch shaded = shaded_alone(tree);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::size_t f = 0; f < shaded.faces.size(); ++f) append_triangles(shaded, f, triangles);
  double sum = 0;
  for (const auto& t : triangles) {
    std::array<Vec2, 3> p;
    for (std::size_t k = 0; k < 3; ++k)
      p[k] = t[k] < shaded.corners.size() ? shaded.corners[t[k]].p
                                          : shaded.faces[t[k] - shaded.corners.size()].center.p;
    const double a = area2(p[0], p[1], p[2]);
    EXPECT_GT(a, 0);  // counter-clockwise, none degenerate
    sum += 0.5 * a;
  }
  EXPECT_NEAR(sum, 4, 1e-9);
}

// Where something stands on the surface, light jumps: the sides keep their own colours.
TEST(ShadedPatch, LightJumpsAcrossAContact) {
  testing::Patches patches(kOrder);
  const Polygon square{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}};
  testing::Paint paint;
  paint.reflectance = Spectrum(1);
  const Contact wall{{1, 0, 0}, {1, 2, 0}};
  PatchTree tree = patches.tree(patches.add(square, paint, std::span(&wall, 1)));
  ASSERT_TRUE(split_leaf(tree, 0, 1e-3));
  std::fill(tree.e.begin(), tree.e.end(), 0.0);
  for (std::size_t child = 1; child <= 2; ++child) {
    const bool right = tree.view().point(tree.elements[child].centroid).x > 1;
    for (int c = 0; c < kChannels; ++c)
      tree.e[child * std::size_t(coefficient_count(kOrder) * kChannels) + std::size_t(c)] =
          right ? 100 : 1;
  }
  const ShadedPatch with = shaded_alone(tree);
  tree.contacts.clear();
  const ShadedPatch without = shaded_alone(tree);
  const auto at = [](const ShadedPatch& s, double x) {
    const Vec2 p = s.frame.to_plane({x, 0.7, 0});
    return radiosity_at(s, s.faces[face_at(s, p)], p).x;
  };
  EXPECT_NEAR(at(with, 0.999999), 1, 1e-9);
  EXPECT_NEAR(at(with, 1.000001), 100, 1e-9);
  EXPECT_NEAR(at(without, 1), 50.5, 1e-3);
}

// Two patches of one wall, one split finer, with frames of their own: along the rim they share both
// show one colour; with another paint each keeps its own.
TEST(ShadedPatch, PatchesOfOnePlaneAndPaintMeetWithoutASeam) {
  for (const bool same_paint : {true, false}) {
    testing::Patches patches(kOrder);
    testing::Paint paint;
    paint.reflectance = Spectrum(0.5);
    const PatchId left = patches.add(Polygon{{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, paint);
    if (!same_paint) paint.reflectance = Spectrum(0.25);
    const PatchId right = patches.add(Polygon{{2, 3, 0}, {2, 0, 0}, {5, 0, 0}, {5, 3, 0}}, paint);
    std::vector<PatchTree> trees{patches.tree(left), patches.tree(right)};
    for (std::int32_t i = 0; i < 9; ++i) split_leaf(trees[1], i, 1e-3);
    shake(trees[0], 6);
    shake(trees[1], 7);
    const testing::Record record(0, trees);
    const std::vector<ShadedPatch> shaded = shade(record.view(), 1e-7);
    const auto at = [](const ShadedPatch& s, const Vec3& x) {
      const Vec2 p = s.frame.to_plane(x);
      return radiosity_at(s, s.faces[face_at(s, p)], p).x;
    };
    double largest = 0;
    for (double y = 0.05; y < 2; y += 0.1)
      largest = std::max(largest, std::abs(at(shaded[0], {2, y, 0}) - at(shaded[1], {2, y, 0})));
    if (same_paint)
      EXPECT_LT(largest, 1e-6);
    else
      EXPECT_GT(largest, 1);
  }
}

}  // namespace
}  // namespace atrium
