// Push is exact, pull is the L2 projection, detail is what pull leaves out, and neither makes or
// loses light.
#include "solver/push_pull.h"

#include <gtest/gtest.h>

#include <array>

#include "engine/squared.h"
#include "test/solver/shapes.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

constexpr int kOrders[] = {1, 2, 3};

PatchTree tree_of(const Shape& shape, int order, const Paint& paint = {}) {
  Patches patches(order);
  return patches.tree(patches.add(in_plane(shape.outline), paint));
}

void randomize(std::vector<double>& values, std::mt19937& dice) {
  std::uniform_real_distribution<double> number(-1, 1);
  for (double& v : values) v = number(dice);
}

// A shape of aspect a has basis functions that grow with a outside a few digits of it.
double rounding(const Shape& s) { return 1e-12 + 1e-15 * s.aspect * s.aspect; }

// Gathered light on every element of a tree, at random, and none in the row sums.
GatherSlots random_slots(const PatchTree& tree, std::mt19937& dice) {
  const int k = tree.view().k();
  GatherSlots slots;
  slots.reset(tree.elements.size(), k);
  randomize(slots.g, dice);
  return slots;
}

// Calls with(shape, order) for every one.
template <class With>
void for_all_shapes(With&& with) {
  for (const int order : kOrders)
    for (const Shape& shape : shapes()) {
      SCOPED_TRACE(shape.name + ", order " + std::to_string(order));
      with(shape, order);
    }
}

double gathered(const GatherSlots& slots, std::size_t element, int k, int a, int c) {
  return slots.g[(element * k + a) * kGatherChannels + c];
}

TEST(HandDown, PolynomialReproducesItselfAtAnyPoint) {
  std::mt19937 dice(3);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    randomize(tree.e, dice);
    grow(tree, 63);  // split_leaf hands E down
    for (std::size_t i = 1; i < tree.elements.size(); ++i)
      for (int c = 0; c < kChannels; ++c) {
        const Vec2 p = point_of(tree.view().polygon(tree.elements[i]), dice);
        EXPECT_NEAR(value_at(tree, i, p, c), value_at(tree, 0, p, c), 10 * rounding(shape));
      }
  });
}

// What arrives at the elements above a leaf and at the leaf itself adds up, point by point.
TEST(PushPull, LeavesHoldTheSumOfWhatTheirAncestorsGathered) {
  std::mt19937 dice(4);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    grow(tree, 31);
    const GatherSlots given = random_slots(tree, dice);
    GatherSlots slots = given;
    push_pull(tree, slots, {});
    const PatchView v = tree.view();
    for (std::size_t i = 0; i < tree.elements.size(); ++i) {
      if (!tree.elements[i].leaf()) continue;
      const Vec2 p = point_of(v.polygon(tree.elements[i]), dice);
      for (int c = 0; c < kChannels; ++c) {
        double sum = 0;
        for (std::int32_t up = static_cast<std::int32_t>(i); up >= 0;
             up = tree.elements[up].parent) {
          const BasisValues phi = evaluate_basis(v.basis_of(up), tree.elements[up], order, p);
          for (int a = 0; a < v.k(); ++a) sum += phi[a] * gathered(given, up, v.k(), a, c);
        }
        EXPECT_NEAR(value_at(tree, i, p, c), sum, 10 * rounding(shape));
      }
    }
  });
}

// Along an outline's longest edge.
struct Frame2 {
  Vec2 origin{0}, along{1, 0};
  double length = 0, width = 0;
};

Frame2 frame_along(std::span<const Vec2> outline) {
  Frame2 f;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 edge = outline[(i + 1) % outline.size()] - outline[i];
    if (length(edge) <= f.length) continue;
    f.length = length(edge);
    f.origin = outline[i];
    f.along = edge / f.length;
  }
  for (const Vec2& p : outline) {
    const Vec2 d = p - f.origin;
    f.width = std::max(f.width, std::abs(f.along.x * d.y - f.along.y * d.x));
  }
  return f;
}

// The best polynomial fit to a piecewise function over the whole outline, by normal equations in
// monomials along and across the outline, in units of its extents, and elimination: nothing of it
// is shared with the solver. Its value at a point.
double monomial(const Frame2& frame, const Vec2& p, int i) {
  const Vec2 d = p - frame.origin;
  const double x = dot(frame.along, d), y = frame.along.x * d.y - frame.along.y * d.x;
  const double s = x / frame.length, t = y / frame.width;
  return std::array{1.0, s, t, s * s, s * t, t * t}[i];
}

std::array<double, kMaxCoefficients> least_squares(const PatchTree& tree, const Frame2& frame,
                                                   int k, int channel) {
  double a[kMaxCoefficients][kMaxCoefficients + 1] = {};
  for (std::size_t n = 0; n < tree.elements.size(); ++n) {
    if (!tree.elements[n].leaf()) continue;
    const std::span<const Vec2> outline = tree.view().polygon(tree.elements[n]);
    for (int i = 0; i < k; ++i) {
      for (int j = 0; j < k; ++j)
        a[i][j] += integrate(outline, 0, [&](const Vec2& p) {
          return monomial(frame, p, i) * monomial(frame, p, j);
        });
      a[i][k] += integrate(outline, 0, [&](const Vec2& p) {
        return monomial(frame, p, i) * value_at(tree, n, p, channel);
      });
    }
  }
  for (int i = 0; i < k; ++i)
    for (int r = i + 1; r < k; ++r) {
      const double f = a[r][i] / a[i][i];
      for (int j = i; j <= k; ++j) a[r][j] -= f * a[i][j];
    }
  std::array<double, kMaxCoefficients> x{};
  for (int i = k; i-- > 0;) {
    x[i] = a[i][k];
    for (int j = i + 1; j < k; ++j) x[i] -= a[i][j] * x[j];
    x[i] /= a[i][i];
  }
  return x;
}

TEST(PushPull, PullIsTheLeastSquaresFit) {
  std::mt19937 dice(5);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    grow(tree, 31);
    GatherSlots slots = random_slots(tree, dice);
    push_pull(tree, slots, {});
    const std::span<const Vec2> outline = tree.view().polygon(tree.elements[0]);
    const int k = tree.view().k();
    const Frame2 frame = frame_along(outline);
    for (int c = 0; c < kChannels; ++c) {
      const std::array<double, kMaxCoefficients> fit = least_squares(tree, frame, k, c);
      for (const Vec2& p : outline) {
        double expected = 0;
        for (int i = 0; i < k; ++i) expected += fit[i] * monomial(frame, p, i);
        EXPECT_NEAR(value_at(tree, 0, p, c), expected, 100 * rounding(shape));
      }
    }
  });
}

TEST(PushPull, DetailIsTheNormOfWhatThePullLeavesOut) {
  std::mt19937 dice(6);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    grow(tree, 31);
    GatherSlots slots = random_slots(tree, dice);
    push_pull(tree, slots, {});
    const auto lum = [&](std::size_t i, const Vec2& p) {
      return luminance({value_at(tree, i, p, 0), value_at(tree, i, p, 1), value_at(tree, i, p, 2)});
    };
    double rest2 = 0;
    for (std::size_t n = 0; n < tree.elements.size(); ++n) {
      if (!tree.elements[n].leaf()) continue;
      EXPECT_EQ(tree.elements[n].detail, 0);
      rest2 += integrate(tree.view().polygon(tree.elements[n]), 0,
                         [&](const Vec2& p) { return squared(lum(n, p) - lum(0, p)); });
    }
    EXPECT_NEAR(tree.elements[0].detail, std::sqrt(rest2 / tree.elements[0].area),
                1e4 * rounding(shape));
  });
}

// Constant over the patch: nothing is left out, whatever the tree.
TEST(PushPull, UniformLightHasNoDetail) {
  PatchTree tree = tree_of(shapes()[5], 2);
  grow(tree, 63);
  GatherSlots slots;
  slots.reset(tree.elements.size(), tree.view().k());
  for (int c = 0; c < kGatherChannels; ++c) slots.g[c] = 5;
  push_pull(tree, slots, {});
  // Rounding of a difference of squares: √ε × the value.
  for (const Element& x : tree.elements) EXPECT_LT(x.detail, 5 * 1e-7);
}

TEST(PushPull, ConservesFlux) {
  std::mt19937 dice(8);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    grow(tree, 101);
    const GatherSlots given = random_slots(tree, dice);
    GatherSlots slots = given;
    push_pull(tree, slots, {});
    const PatchView v = tree.view();
    for (int c = 0; c < kChannels; ++c) {
      double arrived = 0, held = 0;
      for (std::size_t i = 0; i < tree.elements.size(); ++i) {
        const Element& x = tree.elements[i];
        arrived += x.area * gathered(given, i, v.k(), 0, c);
        if (x.leaf()) held += x.area * v.e_of(i)[c];
      }
      const double size = tree.elements[0].area;
      EXPECT_NEAR(held, arrived, 10 * size * rounding(shape));
      EXPECT_NEAR(size * v.e_of(0)[c], arrived, 10 * size * rounding(shape));
    }
  });
}

TEST(PushPull, SumsAreThoseOfTheLeaves) {
  const Paint paint{Spectrum{.2, .5, .8}, Spectrum{1, 2, 3}};
  PatchTree tree = tree_of(shapes()[3], 2, paint);  // unit square
  grow(tree, 15);
  GatherSlots slots;
  slots.reset(tree.elements.size(), tree.view().k());
  const Spectrum e{10, 20, 30};
  for (int c = 0; c < kChannels; ++c) slots.g[c] = e[c];
  const PushPullSums s = push_pull(tree, slots, {});
  EXPECT_NEAR(s.area, 1, 1e-14);
  EXPECT_NEAR(s.flux_in, luminance(e), 1e-12);
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(s.absorbed[c], (1 - paint.reflectance[c]) * e[c], 1e-12);
    EXPECT_NEAR(s.reflected[c], paint.reflectance[c] * e[c], 1e-12);
    EXPECT_NEAR(s.emitted[c], paint.exitance[c], 1e-12);
  }
  // From E = 0 to e: ΔB = ρe everywhere.
  EXPECT_NEAR(s.change2, squared(luminance(paint.reflectance * e)), 1e-10);
  EXPECT_NEAR(s.change, luminance(paint.reflectance * e), 1e-12);
  slots.reset(tree.elements.size(), tree.view().k());
  for (int c = 0; c < kChannels; ++c) slots.g[c] = e[c];
  const PushPullSums again = push_pull(tree, slots, {});
  EXPECT_NEAR(again.change2, 0, 1e-20);
}

TEST(PushPull, WhatIsTakenBeyondTheGatherIsNoPartOfItsChange) {
  const Paint paint{Spectrum{.5}, Spectrum{0}};
  PatchTree tree = tree_of(shapes()[3], 1, paint);  // unit square, constant
  const auto gathered = [&](double e, double over) {
    GatherSlots slots;
    slots.reset(1, 1);
    for (int c = 0; c < kChannels; ++c) slots.g[c] = e;
    return push_pull(tree, slots, {}, over);
  };
  gathered(8, 1);
  const PushPullSums s = gathered(12, 1.5);  // 8 + 1.5 (12 - 8)
  EXPECT_DOUBLE_EQ(tree.e[0], 14);
  EXPECT_DOUBLE_EQ(s.gained[0], 6);
  EXPECT_DOUBLE_EQ(s.beyond[0], 2);
  EXPECT_NEAR(s.change, .5 * 4, 1e-14);
  EXPECT_NEAR(s.change2, squared(.5 * 4), 1e-14);
  // 14 + 1.5 (2 - 14) is below zero: the gather's own is kept.
  const PushPullSums dark = gathered(2, 1.5);
  EXPECT_DOUBLE_EQ(tree.e[0], 2);
  EXPECT_DOUBLE_EQ(dark.beyond[0], 0);
}

// From dark, quarters that gather 1 to 4 times over: each place has gained its own, and none above
// or below.
TEST(PushPull, GainsAreToldByThePlacesAskedFor) {
  PatchTree tree = tree_of(shapes()[3], 1);  // unit square
  grow(tree, 31);
  GatherSlots slots;
  slots.reset(tree.elements.size(), 1);
  for (std::size_t quarter = 3; quarter < 7; ++quarter)
    slots.g[quarter * kGatherChannels] = double(quarter - 2);
  std::vector<PlaceGain> gains(8);
  const PushPullSums s = push_pull(tree, slots, {}, 1.5, gains);
  for (std::size_t q = 0; q < 8; ++q) {
    EXPECT_NEAR(gains[q].area, q < 4 ? 0 : .25, 1e-14);
    EXPECT_NEAR(gains[q].gained.x, q < 4 ? 0 : 1.5 * .25 * double(q - 3), 1e-14);
    EXPECT_NEAR(gains[q].beyond.x, q < 4 ? 0 : .5 * .25 * double(q - 3), 1e-14);
  }
  EXPECT_NEAR(s.gained.x, 1.5 * .25 * (1 + 2 + 3 + 4), 1e-14);
}

// E of a patch of one constant element that has gathered g, row sum last.
std::vector<double> closed(std::vector<double> g, const Closing& closing) {
  PatchTree tree = tree_of(shapes()[3], 1);
  GatherSlots slots;
  slots.reset(1, 1);
  slots.g = std::move(g);
  push_pull(tree, slots, closing);
  return tree.e;
}

TEST(Closing, MissingShareComesFromTheRoom) {
  const Spectrum e{10, 20, 30}, room{100, 200, 400};
  const std::vector<double> got =
      closed({e[0], e[1], e[2], 0.9}, {.how = Closing::How::kEachLeaf, .mean_radiosity = room});
  for (int c = 0; c < kChannels; ++c) EXPECT_NEAR(got[c], e[c] + 0.1 * room[c], 1e-12);
}

// What is in doubt of two halves together is of 100 lm/m², by a weight of 1, and beside it of one of
// them 700 by 2: what their rows miss comes from 100 and from (100 + 2 × 700) ÷ 3.
TEST(Closing, MissingShareComesFromWhatIsInDoubtThere) {
  PatchTree tree = tree_of(shapes()[3], 1);
  grow(tree, 3);
  GatherSlots slots;
  slots.reset(3, 1);
  for (const std::size_t leaf : {1u, 2u}) slots.g[leaf * kGatherChannels + kRowSum] = 0.9;
  slots.doubts[0] = {1, Spectrum{100}};
  slots.doubts[2] = {2, Spectrum{2 * 700}};
  push_pull(tree, slots, {.how = Closing::How::kEachLeaf, .mean_radiosity = Spectrum{1e6}});
  constexpr double kOfPatch = 1e-8 * 1e6;  // what hardly counts where there are doubts
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(tree.e[1 * kChannels + c], 0.1 * 100, kOfPatch);
    EXPECT_NEAR(tree.e[2 * kChannels + c], 0.1 * 500, kOfPatch);
  }
}

// A row misses .2 while its doubts' standard deviation is .1: they explain a quarter of the square,
// and the rest comes from all that the patch sees.
TEST(Closing, WhatDoubtsDoNotExplainComesFromAllThatThePatchSees) {
  PatchTree tree = tree_of(shapes()[3], 1);
  GatherSlots slots;
  slots.reset(1, 1);
  slots.g[kRowSum] = 0.8;
  slots.doubts[0] = {0.01, Spectrum{0.01 * 1000}};
  push_pull(tree, slots, {.how = Closing::How::kEachLeaf, .mean_radiosity = Spectrum{100}});
  const double mean = (0.01 * 1000 + (0.04 - 0.01) * 100) / 0.04;
  for (int c = 0; c < kChannels; ++c) EXPECT_NEAR(tree.e[std::size_t(c)], 0.2 * mean, 1e-9);
}

TEST(Closing, OpenRowsAreLeftAsTheyAre) {
  EXPECT_EQ(
      closed({10, 20, 30, 0.9}, {.how = Closing::How::kOpen, .mean_radiosity = Spectrum{100}}),
      (std::vector<double>{10, 20, 30}));
}

// A row that sums to four times the whole keeps a quarter of its light; one below keeps all.
TEST(Closing, RowsFarTooMuchAreScaled) {
  const Closing no_more{.how = Closing::How::kNoMore, .whole = 0.5};
  EXPECT_EQ(closed({10, 20, 30, 2}, no_more), (std::vector<double>{2.5, 5, 7.5}));
  EXPECT_EQ(closed({10, 20, 30, 0.25}, no_more), (std::vector<double>{10, 20, 30}));
}

// Where nothing leaves the scene rows of either kind are made to sum to 1: in uniform light, 100
// lm/m² from everywhere, E is that whatever the links brought.
TEST(Closing, RowsOfAClosedPatchThatAreScaledAreFilledToo) {
  const Closing closing{.how = Closing::How::kNoMoreNorLess, .mean_radiosity = Spectrum{100}};
  for (const double row : {0.25, 0.9, 1.0, 1.5, 4.0})
    for (const double e : closed({100 * row, 100 * row, 100 * row, row}, closing))
      EXPECT_NEAR(e, 100, 1e-12 * 100);
}

TEST(Closing, TakesOffNoMoreThanThereIs) {
  EXPECT_EQ(closed({10, 20, 30, 1.25},
                   {.how = Closing::How::kEachLeaf, .mean_radiosity = Spectrum{100, 40, 40}}),
            (std::vector<double>{0, 10, 20}));
}

// A mean that comes out below 0 is 0, and what varies about it, 5 here, falls to nothing as that
// goes down to -5: no step, across which sweeps would go back and forth.
TEST(Closing, WhatVariesFadesOutAsItsMeanIsTakenOff) {
  for (const double below : {1e-9, 1.0, 4.0, 5.0, 20.0}) {
    PatchTree tree = tree_of(shapes()[3], 2);
    GatherSlots slots;
    slots.reset(1, tree.view().k());
    slots.g[kRowSum] = 1.5;  // half of 100 is taken off
    slots.g[0] = 50 - below;
    slots.g[kGatherChannels] = 3;
    slots.g[2 * kGatherChannels] = 4;
    push_pull(tree, slots, {.how = Closing::How::kEachLeaf, .mean_radiosity = Spectrum{100}});
    const double kept = std::max(0.0, 1 - below / 5);
    EXPECT_EQ(tree.e[0], 0);
    EXPECT_NEAR(tree.e[kChannels], 3 * kept, 1e-12);
    EXPECT_NEAR(tree.e[2 * kChannels], 4 * kept, 1e-12);
  }
}

// What a patch as a whole misses is spread over all of it.
TEST(Closing, WholePatchGetsItsMissingShareEverywhere) {
  PatchTree tree = tree_of(shapes()[3], 2);
  grow(tree, 7);
  GatherSlots slots;
  slots.reset(tree.elements.size(), tree.view().k());
  const Spectrum e{10, 20, 30}, room{100, 200, 400};
  for (int c = 0; c < kChannels; ++c) slots.g[c] = e[c];
  slots.g[kRowSum] = 0.7;  // a tenth of the directions leaves the scene
  push_pull(tree, slots,
            {.how = Closing::How::kWholePatch, .missing = 0.2, .mean_radiosity = room});
  for (std::size_t i = 0; i < tree.elements.size(); ++i)
    for (const Vec2& p : tree.view().polygon(tree.elements[i]))
      for (int c = 0; c < kChannels; ++c)
        EXPECT_NEAR(value_at(tree, i, p, c), e[c] + 0.2 * room[c], 1e-11);
}

// In a furnace every source has the same B: whatever the row sums are, and however they vary over
// the element, E = B once rows are closed.
TEST(Closing, FurnaceIsUniformWhateverTheRowsAre) {
  std::mt19937 dice(9);
  for_all_shapes([&](const Shape& shape, int order) {
    PatchTree tree = tree_of(shape, order);
    grow(tree, 15);
    GatherSlots slots = random_slots(tree, dice);
    const Spectrum b{7, 5, 3};
    const int k = tree.view().k();
    for (std::size_t i = 0; i < tree.elements.size() * k; ++i)
      for (int c = 0; c < kChannels; ++c)
        slots.g[i * kGatherChannels + c] = b[c] * slots.g[i * kGatherChannels + kRowSum];
    push_pull(tree, slots, {.how = Closing::How::kEachLeaf, .mean_radiosity = b});
    for (std::size_t i = 0; i < tree.elements.size(); ++i)
      for (const Vec2& p : tree.view().polygon(tree.elements[i]))
        for (int c = 0; c < kChannels; ++c)
          EXPECT_NEAR(value_at(tree, i, p, c), b[c], 1000 * rounding(shape));
  });
}

}  // namespace
}  // namespace atrium::testing
