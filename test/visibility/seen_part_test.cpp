// What a point sees of a polygon past blockers: by the rules of projection where there is one, and
// by random segments where there are many.
#include "visibility/seen_part.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace atrium {
namespace {

constexpr double kTolerance = 1e-6;  // m, of scenes some metres wide
const Vec3 kEye{0, 0, 0};
// A square of 4 m, 2 m above the eye, facing down.
const Polygon kCeiling{{-2, -2, 2}, {-2, 2, 2}, {2, 2, 2}, {2, -2, 2}};
const Vec3 kDown{0, 0, -1};

Polygon sheet(double x0, double y0, double x1, double y1, double z) {
  return {{x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z}};
}

struct Blockers {
  std::vector<Polygon> polygons;
  std::vector<BlockerPolygon> all;
  std::vector<std::uint32_t> positions;
  explicit Blockers(std::vector<Polygon> list) : polygons(std::move(list)) {
    for (const Polygon& p : polygons) {
      positions.push_back(std::uint32_t(all.size()));
      all.push_back({p, positions.back()});
    }
  }
  Remainder seen(const Vec3& x = kEye) const {
    return seen_part(x, kCeiling, kDown, {positions, all, kTolerance});
  }
};

double seen_area(const Remainder& r) {
  double sum = 0;
  for (const ConvexPiece& piece : std::span(r.pieces).first(r.count)) sum += area(piece.polygon());
  return sum;
}

TEST(SeenPart, SheetHalfWayHidesFourTimesItsArea) {
  const Remainder r = Blockers({sheet(-0.3, 0.1, 0.5, 0.7, 1)}).seen();
  EXPECT_FALSE(r.whole);
  EXPECT_NEAR(seen_area(r), 16 - 4 * 0.8 * 0.6, 1e-9);
}

// 0.5 × 1 of overlap at height 1, of two of 1 × 1.
TEST(SeenPart, OverlappingSheetsHideTheirUnionOnce) {
  const Remainder r = Blockers({sheet(-1, 0, 0, 1, 1), sheet(-0.5, 0, 0.5, 1, 1)}).seen();
  EXPECT_NEAR(seen_area(r), 16 - 4 * 1.5, 1e-9);
}

TEST(SeenPart, HalvesThatMeetHideAllAndASlitIsSeen) {
  const Polygon left = sheet(-3, -3, 0.2, 3, 1);
  EXPECT_TRUE(Blockers({left, sheet(0.2, -3, 3, 3, 1)}).seen().nothing());
  const Remainder slit = Blockers({left, sheet(0.201, -3, 3, 3, 1)}).seen();
  EXPECT_NEAR(seen_area(slit), 0.002 * 4, 1e-9);  // a millimetre, from half way, along the ceiling
}

TEST(SeenPart, WhatIsNotBetweenHidesNothing) {
  EXPECT_TRUE(Blockers({sheet(-1, -1, 1, 1, 3)}).seen().whole);   // behind the ceiling
  EXPECT_TRUE(Blockers({sheet(-1, -1, 1, 1, 2)}).seen().whole);   // in it
  EXPECT_TRUE(Blockers({sheet(-1, -1, 1, 1, -1)}).seen().whole);  // below the eye
  EXPECT_TRUE(Blockers({sheet(5, 5, 6, 6, 1)}).seen().whole);     // beside
  EXPECT_TRUE(
      Blockers({{{0, -1, 0.5}, {0, 1, 0.5}, {0, 1, 1}, {0, -1, 1}}}).seen().whole);  // edge on
}

TEST(SeenPart, NothingFromBehind) {
  EXPECT_TRUE(Blockers({}).seen({0, 0, 3}).nothing());
  EXPECT_TRUE(Blockers({}).seen({0, 0, 2}).nothing());
}

// A wall that reaches from below the eye through the ceiling, at x = 0.5: all beyond is hidden.
TEST(SeenPart, WallThroughTheCeilingHidesWhatIsBeyond) {
  const Remainder r = Blockers({{{0.5, -9, -1}, {0.5, 9, -1}, {0.5, 9, 5}, {0.5, -9, 5}}}).seen();
  EXPECT_NEAR(seen_area(r), 2.5 * 4, 1e-4);
}

bool inside(PolygonView polygon, const Vec3& normal, const Vec3& x) {
  return contains(polygon, normal, x, 0);
}

bool blocked(const Vec3& from, const Vec3& to, PolygonView polygon) {
  const Plane plane = plane_of(polygon);
  const double a = plane.distance(from), b = plane.distance(to);
  return a * b < 0 && inside(polygon, plane.normal, from + (to - from) * (a / (a - b)));
}

// Every segment's fate is that of the piece its end is in. Among random polygons none ends within
// 1e-9 of a shadow's edge, and the tolerance is the only excuse.
TEST(SeenPart, PiecesAreWhatRandomSegmentsReach) {
  std::mt19937 dice(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  int seen_count = 0, blocked_count = 0, doubtful = 0;
  for (int scene = 0; scene < 300; ++scene) {
    std::vector<Polygon> list;
    for (int b = 0; b < 5; ++b) {
      const Vec3 center{1.5 * unit(dice), 1.5 * unit(dice), 1 + 1.2 * unit(dice)};
      const Vec3 u{unit(dice), unit(dice), unit(dice)}, v{unit(dice), unit(dice), unit(dice)};
      list.push_back({center, center + u, center + v});
    }
    const Blockers blockers(list);
    const Remainder r = blockers.seen();
    ASSERT_FALSE(r.overflow);
    for (int k = 0; k < 200; ++k) {
      const Vec3 y{2 * unit(dice), 2 * unit(dice), 2};
      const bool hidden = std::any_of(list.begin(), list.end(),
                                      [&](const Polygon& p) { return blocked(kEye, y, p); });
      int pieces = 0;
      for (const ConvexPiece& piece : std::span(r.pieces).first(r.count))
        pieces += inside(piece.polygon(), kDown, y);
      ++(hidden ? blocked_count : seen_count);
      doubtful += pieces != (hidden ? 0 : 1);
    }
  }
  EXPECT_GT(seen_count, 5000);
  EXPECT_GT(blocked_count, 5000);
  EXPECT_LE(doubtful, 6);  // of 60,000: edges within some 1e-5 of 4 m
}

TEST(SeenPart, TooManyPiecesAreSaidSo) {
  std::vector<Polygon> list;
  for (int i = 0; i < 40; ++i) list.push_back(sheet(-1 + 0.05 * i, -0.5, -0.98 + 0.05 * i, 0.5, 1));
  EXPECT_TRUE(Blockers(list).seen().overflow);
}

}  // namespace
}  // namespace atrium
