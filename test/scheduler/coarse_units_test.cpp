// The coarse system of two squares of 1 m², clusters of their own that see each other: each is
// divided into eight parts of about an eighth, for K is small.
#include "scheduler/coarse_units.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "scheduler/coarse_rows.h"
#include "scheduler/coarse_solve.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

constexpr std::size_t kParts = 8;
constexpr double kRounding = 1e-13, kFloat = 1e-7;
const ClusterId kFirst{0u}, kSecond{1u};

Model two_squares() {
  Model m;
  for (std::uint32_t c = 0; c < 2; ++c) {
    Patch p;
    p.cluster = ClusterId(c);
    p.first_vertex = std::uint32_t(m.vertices.size());
    p.vertex_count = 4;
    for (const Vec3& v : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{1, 1, 0}, Vec3{0, 1, 0}})
      m.vertices.push_back(v);
    Cluster cluster;
    cluster.first_patch = c;
    cluster.patch_count = 1;
    m.patches.push_back(p);
    m.clusters.push_back(cluster);
    const ClusterId other(1 - c);
    m.visible.push_row(std::span(&other, 1));
  }
  return m;
}

// Of such a square: halves, quarters and eighths, breadth first.
PatchTree tree_of_square(double reflectance) {
  Patches patches;
  PatchTree tree = patches.tree(
      patches.add(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), {Spectrum{reflectance}, {}}));
  grow(tree, 15);
  return tree;
}

TEST(CoarseUnits, PatchesThatAreLargeAmongThemAreDivided) {
  const CoarseUnits units(two_squares(), Division::kWhereItPays);
  ASSERT_EQ(units.size(), 2 * (1 + kParts));  // and what is left of each cluster: nothing
  const std::uint32_t part = units.of(kSecond)[0];
  EXPECT_EQ(part, units.first(kSecond) + 1);
  EXPECT_EQ(units.parts(part), kParts);
  EXPECT_EQ(units.first_part(part + kParts - 1), part);
  for (std::size_t i = 0; i < kParts; ++i) EXPECT_EQ(units.areas()[part + i], 1.0 / kParts);
  EXPECT_FALSE(units.divided(units.first(kSecond)));
  EXPECT_EQ(CoarseUnits(two_squares(), Division::kNone).size(), 4u);
}

// K of many pairs would grow beyond what it saves: no patch is divided then.
TEST(CoarseUnits, NothingIsDividedWhereTheCoarseSystemIsLarge) {
  Model model = two_squares();
  model.visible.items.resize(1 << 20);
  EXPECT_EQ(CoarseUnits(model, Division::kWhereItPays).size(), 4u);
}

// Leaves of .1 and .3 m² at places 4 and 5, of .6 at place 3. What is larger than a part, at places
// from 8 on, is of the parts below by halves: .05, .05, .15, .15 and four times .15.
TEST(CoarseUnits, LeavesLargerThanPartsCountWithEqualSharesToThem) {
  CoarseUnits units(two_squares(), Division::kWhereItPays);
  PatchGain gain;
  gain.places.resize(2 * kParts);
  gain.places[4] = {.1, Spectrum{8}, Spectrum{2}};
  gain.places[5] = {.3, Spectrum{0}, Spectrum{0}};
  gain.places[3] = {.6, Spectrum{4}, Spectrum{0}};
  const std::vector<PlaceGain> gains = units.gains(kFirst, std::span(&gain, 1));
  const double area[] = {.05, .05, .15, .15, .15, .15, .15, .15};
  const double gained[] = {4, 4, 0, 0, 1, 1, 1, 1};
  for (std::size_t i = 0; i < kParts; ++i) {
    EXPECT_NEAR(units.areas()[1 + i], area[i], kRounding) << i;
    EXPECT_NEAR(gains[1 + i].gained.x, gained[i], kRounding) << i;
    EXPECT_NEAR(gains[1 + i].beyond.x, i < 2 ? 1 : 0, kRounding) << i;
  }

  // Light of 1 on the first part: its place's parent has the mean of two equal areas, the patch a
  // twentieth.
  std::vector<Spectrum> light(units.size(), Spectrum{0});
  light[1] = Spectrum{1};
  const PlacedLight placed = units.placed(kFirst, light);
  EXPECT_NEAR(placed.by_place(0)[kParts].x, 1, kRounding);
  EXPECT_NEAR(placed.by_place(0)[kParts / 2].x, .5, kRounding);
  EXPECT_NEAR(placed[0].x, .05, kRounding);
}

// A link of .5 between the squares, and one of .25 between their first quarters: parts of those
// receive both. Of the whole an eighth comes from each part, of a quarter half from each of two.
class Rows : public ::testing::Test {
 protected:
  Rows() {
    LinkSet set;
    set.thin = {{{0, 0, 0}, .5f}, {{3, 0, 3}, .25f}};
    set.doubts = {{{0, 0, 0}, 1}};
    rows_.add(plait(kFirst, std::span(&set, 1)), source_.view(), std::span(&receiver_, 1));
  }

  std::vector<CoarseEntry> row(std::size_t part) const {
    return rows_.row(units_.of(kSecond)[0] + std::uint32_t(part));
  }

  static constexpr double kReflectance = .5;
  CoarseUnits units_{two_squares(), Division::kWhereItPays};
  PatchTree receiver_ = tree_of_square(0), sender_ = tree_of_square(kReflectance);
  Record source_{0, std::span(&sender_, 1)};
  CoarseRows rows_{units_, kSecond};
};

TEST_F(Rows, LinksOfLargerElementsAreOfAllTheirPartsByArea) {
  rows_.close(0, receiver_, {});
  for (std::size_t to = 0; to < kParts; ++to) {
    const std::vector<CoarseEntry> found = row(to);
    ASSERT_EQ(found.size(), kParts);
    for (std::size_t from = 0; from < kParts; ++from) {
      const double factor = .5 / 8 + (to < 2 && from < 2 ? .25 / 2 : 0);
      EXPECT_EQ(found[from].unit, units_.of(kFirst)[0] + from);
      EXPECT_NEAR(found[from].form_factor, factor, kFloat);
      EXPECT_NEAR(found[from].share[0], kReflectance * factor, kFloat);
    }
  }
}

// What is missing, .25 in the first two parts and .5 elsewhere, is made up from all that is in
// doubt: from what the whole sees of the whole, and there from the first two parts beside.
TEST_F(Rows, PartsAreClosedEachForItself) {
  Closing closing{.how = Closing::How::kEachLeaf};
  closing.missing = 1 - .5 - .25 / 4;
  rows_.close(0, receiver_, closing);
  for (std::size_t to = 0; to < kParts; ++to) {
    double sum = 0;
    for (const CoarseEntry& e : row(to)) sum += e.form_factor;
    EXPECT_NEAR(sum, 1, kParts * kFloat);
    const double of_whole = 1 + ThinLink{{}, .5f}.doubt(), of_quarter = ThinLink{{}, .25f}.doubt();
    const double doubts = of_whole + (to < 2 ? of_quarter : 0);
    const double made_up = (to < 2 ? .25 : .5) / doubts * of_whole / 8;
    EXPECT_NEAR(row(to)[kParts - 1].form_factor, .5 / 8 + made_up, kFloat);
  }
}

// Rows of random entries that sum to .99, each square's to the other's parts.
CoarseMatrix random_rows(const CoarseUnits& units, std::mt19937& dice) {
  constexpr double kWhite = .99;
  std::uniform_real_distribution<double> number(0, 1);
  CoarseMatrix k(units.size());
  for (const ClusterId to : {kFirst, kSecond}) {
    const std::uint32_t first = units.of(to)[0], from = units.of(ClusterId(1 - to.value))[0];
    for (std::uint32_t u = first; u < first + units.parts(first); ++u) {
      double sum = 0;
      for (std::uint32_t v = from; v < from + units.parts(from); ++v) {
        const float f = float(number(dice));
        k[u].push_back({v, {f, f, f}, f});
        sum += f;
      }
      for (CoarseEntry& e : k[u])
        for (float& s : e.share) s = float(s * kWhite / sum);
    }
  }
  return k;
}

// What a part sends goes for the most part to the next one of the other square, round and round: a
// step in their order hands an error on undiminished, and what it leaves over patches does not tell
// of it. A cycle by itself makes more of it; cycles taken together leave less.
TEST(CoarseSolve, CyclesThatDoNotConvergeByThemselvesDoTogether) {
  const CoarseUnits units(two_squares(), Division::kWhereItPays);
  constexpr float kWhite = .999f, kAcross = 1.8f, kBack = kWhite - kAcross;
  CoarseMatrix k(units.size());
  for (const ClusterId to : {kFirst, kSecond}) {
    const std::uint32_t first = units.of(to)[0], from = units.of(ClusterId(1 - to.value))[0];
    const auto entry = [&](std::uint32_t part, float f) {
      return CoarseEntry{from + part % std::uint32_t(kParts), {f, f, f}, f};
    };
    for (std::uint32_t i = 0; i < kParts; ++i) {
      k[first + i] = {entry(i, kAcross), entry(i + 1, kBack)};
      std::ranges::sort(k[first + i], {}, &CoarseEntry::unit);
    }
  }
  std::mt19937 dice(7);
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Spectrum> r(units.size());
  for (Spectrum& s : r) s = Spectrum{number(dice)};
  const std::vector<Spectrum> x = solve_coarse(units, k, 1, r);
  double left2 = 0, all2 = 0;
  for (std::size_t u = 0; u < units.size(); ++u) {
    Spectrum left = r[u] - x[u];
    for (const CoarseEntry& e : k[u]) left += share_of(e) * x[e.unit];
    left2 += dot(left, left);
    all2 += dot(r[u], r[u]);
  }
  EXPECT_LT(left2, all2);
}

TEST(CoarseSolve, LeavesAFifthAtTheMostAndOfUndividedPatchesNothing) {
  for (const Division division : {Division::kNone, Division::kWhereItPays}) {
    const CoarseUnits units(two_squares(), division);
    std::mt19937 dice(3);
    const CoarseMatrix k = random_rows(units, dice);
    std::vector<Spectrum> r(units.size());
    std::uniform_real_distribution<double> number(-1, 1);
    for (Spectrum& s : r) s = {number(dice), number(dice), number(dice)};
    const std::vector<Spectrum> x = solve_coarse(units, k, 1, r);
    const std::vector<std::uint32_t> patch = undivided_numbers(units);
    std::vector<double> rest(patch.back() + 1, 0);  // of each patch, its mean
    double left2 = 0, all2 = 0;
    for (std::size_t u = 0; u < units.size(); ++u) {
      Spectrum left = r[u] - x[u];
      for (const CoarseEntry& e : k[u]) left += share_of(e) * x[e.unit];
      rest[patch[u]] += left.x;
      left2 += dot(left, left);
      all2 += dot(r[u], r[u]);
    }
    EXPECT_LT(left2, (division == Division::kNone ? 1e-12 : .04) * all2);
    for (const double mean : rest) EXPECT_NEAR(mean, 0, 1e-6);
  }
}

}  // namespace
}  // namespace atrium::testing
