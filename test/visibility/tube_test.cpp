#include "visibility/tube.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "visibility/occlusion.h"

namespace atrium {
namespace {

constexpr double kTolerance = 1e-6;  // m, of a room some metres wide

PolygonPair pair(const Polygon& p, const Polygon& q) {
  return {p, plane_of(p).normal, q, plane_of(q).normal};
}

struct WorkingSet {
  std::vector<Polygon> polygons;
  std::vector<BlockerPolygon> blockers;
  BlockerIndex index;
  explicit WorkingSet(std::vector<Polygon> list) : polygons(std::move(list)) {
    for (std::size_t i = 0; i < polygons.size(); ++i)
      blockers.push_back({polygons[i], std::uint32_t(i)});
    index = BlockerIndex(blockers);
  }
  Variety between(const Polygon& p, const Polygon& q, double tolerance) const {
    Tube tube = make_tube(pair(p, q), index, tolerance);
    return variety(tube, pair(p, q), index, tolerance);
  }
};

std::vector<Polygon> room() {
  return {
      {{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {0, 3, 0}}, {{0, 0, 2}, {0, 3, 2}, {4, 3, 2}, {4, 0, 2}},
      {{0, 0, 0}, {0, 0, 2}, {4, 0, 2}, {4, 0, 0}}, {{0, 3, 0}, {4, 3, 0}, {4, 3, 2}, {0, 3, 2}},
      {{0, 0, 0}, {0, 3, 0}, {0, 3, 2}, {0, 0, 2}}, {{4, 0, 0}, {4, 0, 2}, {4, 3, 2}, {4, 3, 0}}};
}

// A horizontal plate at half height, its near side at y = 0.
Polygon plate(double x0, double x1, double y1, double z = 1) {
  return {{x0, 0, z}, {x1, 0, z}, {x1, y1, z}, {x0, y1, z}};
}

// The room's answers must not depend on its size or place: scale, offset.
class AtScaleAndOffset : public testing::TestWithParam<std::pair<double, double>> {
 protected:
  Polygon placed(Polygon p) const {
    const auto [scale, offset] = GetParam();
    for (Vec3& x : p) x = turned(x) * scale + offset * Vec3{1, -1, 0.5};
    return p;
  }
  WorkingSet placed(std::vector<Polygon> list) const {
    for (Polygon& p : list) p = placed(p);
    return WorkingSet(std::move(list));
  }
  double tolerance() const { return kTolerance * GetParam().first; }

 private:
  static Vec3 turned(const Vec3& x) {
    const Vec3 u = normalize(Vec3{3, 1, 2}), v = normalize(cross(u, Vec3{0, 1, 0}));
    return x.x * u + x.y * v + x.z * cross(u, v);
  }
};

TEST_P(AtScaleAndOffset, WallsOfAnEmptyRoomSeeEachOther) {
  const WorkingSet set = placed(room());
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_EQ(set.between(set.polygons[i], set.polygons[j], tolerance()),
                i == j ? Variety::INVISIBLE : Variety::VISIBLE)
          << i << " " << j;
}

TEST_P(AtScaleAndOffset, PlateFromWallToWallHidesTheCeiling) {
  auto list = room();
  list.push_back(plate(0, 4, 3));
  const WorkingSet set = placed(list);
  EXPECT_EQ(set.between(set.polygons[0], set.polygons[1], tolerance()), Variety::INVISIBLE);
  EXPECT_EQ(set.between(set.polygons[2], set.polygons[3], tolerance()), Variety::PARTIAL);
}

TEST_P(AtScaleAndOffset, HalfAPlateHidesPartOfTheCeiling) {
  auto list = room();
  list.push_back(plate(0, 2, 3));
  const WorkingSet set = placed(list);
  EXPECT_EQ(set.between(set.polygons[0], set.polygons[1], tolerance()), Variety::PARTIAL);
  // A segment crosses the plate's height half way: at the mean of its two ends' x.
  const auto floor = [&](double a, double b) {
    return placed(Polygon{{a, 0, 0}, {b, 0, 0}, {b, 3, 0}, {a, 3, 0}});
  };
  const auto ceiling = [&](double a, double b) {
    return placed(Polygon{{a, 0, 2}, {a, 3, 2}, {b, 3, 2}, {b, 0, 2}});
  };
  EXPECT_EQ(set.between(floor(0, 1), ceiling(0, 1), tolerance()), Variety::INVISIBLE);
  EXPECT_EQ(set.between(floor(3, 4), ceiling(3, 4), tolerance()), Variety::VISIBLE);
  EXPECT_EQ(set.between(floor(0, 1), ceiling(2, 3), tolerance()), Variety::INVISIBLE);
  EXPECT_EQ(set.between(floor(1, 2), ceiling(3, 4), tolerance()), Variety::VISIBLE);
  EXPECT_EQ(set.between(floor(0, 2), ceiling(2, 4), tolerance()), Variety::PARTIAL);
  EXPECT_EQ(set.between(floor(0, 1), ceiling(2, 4), tolerance()), Variety::PARTIAL);
}

// The plate of above in pieces: two halves, four quarters that overlap, three with one short of the
// wall by a tenth of the tolerance.
TEST_P(AtScaleAndOffset, PiecesOfAPlateHideTheCeilingTogether) {
  const auto quarter = [](double x0, double x1, double y0, double y1) {
    return Polygon{{x0, y0, 1}, {x1, y0, 1}, {x1, y1, 1}, {x0, y1, 1}};
  };
  for (const std::vector<Polygon>& pieces :
       {std::vector{plate(0, 1.7, 3), plate(1.7, 4, 3)},
        std::vector{quarter(0, 2.1, 0, 1.6), quarter(2, 4, 0, 1.5), quarter(0, 2, 1.5, 3),
                    quarter(1.9, 4, 1.4, 3)},
        std::vector{plate(0, 1, 3), plate(1, 3, 3), plate(3, 4 - 1e-7, 3)}}) {
    auto list = room();
    list.insert(list.end(), pieces.begin(), pieces.end());
    const WorkingSet set = placed(list);
    EXPECT_EQ(set.between(set.polygons[0], set.polygons[1], tolerance()), Variety::INVISIBLE)
        << pieces.size();
  }
}

// A slit of a millimetre, a hole where four meet, and halves at different heights (past which a
// slanted segment finds its way) let light through.
TEST_P(AtScaleAndOffset, PiecesThatLeaveAGapDoNot) {
  for (const std::vector<Polygon>& pieces :
       {std::vector{plate(0, 1.7, 3), plate(1.701, 4, 3)},
        std::vector{plate(0, 1.7, 3), plate(1.7, 4, 2.999)},
        std::vector{plate(0, 1.7, 3, 0.9), plate(1.7, 4, 3, 1.1)}}) {
    auto list = room();
    list.insert(list.end(), pieces.begin(), pieces.end());
    const WorkingSet set = placed(list);
    EXPECT_EQ(set.between(set.polygons[0], set.polygons[1], tolerance()), Variety::PARTIAL);
  }
}

INSTANTIATE_TEST_SUITE_P(Tube, AtScaleAndOffset,
                         testing::Values(std::pair{1.0, 0.0}, std::pair{1e-6, 0.0},
                                         std::pair{1.0, 1e6}, std::pair{1e4, 0.0}));

// Splits p and q down to a depth and holds every verdict against rays, and against tubes drawn
// afresh from the whole working set.
TEST(Tube, ChildrenAgreeWithRaysAndWithFreshTubes) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  auto list = room();
  for (int i = 0; i < 12; ++i) {
    const double x = 3 * unit(random);
    const double z = 0.2 + 1.6 * unit(random);
    list.push_back(plate(x, x + unit(random), 2.5 * unit(random) + 0.3, z));
  }
  // A shelf of three boards in one plane.
  for (const double x : {0.0, 0.7, 1.4}) list.push_back(plate(x, x + 0.7, 1.3, 0.8));
  const WorkingSet set(list);
  const RayScene rays(set.blockers);
  int counts[3] = {0, 0, 0};

  const auto quarter = [](const Polygon& p, int k) {
    Polygon out;
    const Vec3 center = 0.25 * (p[0] + p[1] + p[2] + p[3]);
    for (int i = 0; i < 4; ++i)
      out.push_back(i == k             ? p[i]
                    : (i + 2) % 4 == k ? center
                    : (i + 3) % 4 == k ? 0.5 * (p[k] + p[(k + 1) % 4])
                                       : 0.5 * (p[k] + p[(k + 3) % 4]));
    return out;
  };
  const auto point = [&](const Polygon& p) {
    const double s = unit(random), t = unit(random);
    return (1 - s) * ((1 - t) * p[0] + t * p[1]) + s * ((1 - t) * p[3] + t * p[2]);
  };
  const auto visit = [&](auto&& self, const Polygon& p, const Polygon& q, Tube tube,
                         int depth) -> void {
    const Variety seen = variety(tube, pair(p, q), set.index, kTolerance);
    ++counts[int(seen)];
    EXPECT_EQ(seen, set.between(p, q, kTolerance));
    if (seen != Variety::PARTIAL) {
      for (int i = 0; i < 20; ++i) {
        EXPECT_EQ(rays.occluded(point(p), point(q)), seen == Variety::INVISIBLE);
      }
    }
    if (depth == 0 || seen != Variety::PARTIAL) return;
    for (int k = 0; k < 4; ++k) {
      const Polygon half = quarter(depth % 2 ? p : q, k);
      const Polygon &a = depth % 2 ? half : p, &b = depth % 2 ? q : half;
      self(self, a, b, subdivide(tube, pair(a, b), set.index, kTolerance), depth - 1);
    }
  };
  for (const std::size_t q : {1, 3, 5})
    visit(visit, list[0], list[q], make_tube(pair(list[0], list[q]), set.index, kTolerance), 6);
  for (const int count : counts) EXPECT_GT(count, 100);
}

// More candidates than a tube can list: it says so, and its children find their own.
TEST(Tube, CrowdedUntilItsPartsAreNarrowEnough) {
  auto list = room();
  for (std::size_t i = 0; i < 2 * Tube::kCapacity; ++i) {
    const double x = 4.0 * double(i) / (2.0 * Tube::kCapacity);
    list.push_back({{x, 1, 1}, {x + 0.03, 1, 1}, {x + 0.03, 1.5, 1}, {x, 1.5, 1}});
  }
  const WorkingSet set(list);
  Tube tube = make_tube(pair(list[0], list[1]), set.index, kTolerance);
  EXPECT_TRUE(tube.crowded);
  EXPECT_EQ(variety(tube, pair(list[0], list[1]), set.index, kTolerance), Variety::PARTIAL);

  const Polygon floor{{0, 0, 0}, {0.5, 0, 0}, {0.5, 3, 0}, {0, 3, 0}};
  const Polygon ceiling{{0, 0, 2}, {0, 3, 2}, {0.5, 3, 2}, {0.5, 0, 2}};
  const Tube child = subdivide(tube, pair(floor, ceiling), set.index, kTolerance);
  EXPECT_FALSE(child.crowded);
  EXPECT_EQ(child.count, 8u);  // the plates that begin left of 0.5

  // The same by way of the clusters' boxes.
  const Tube clusters =
      make_tube(make_shaft(bounds(list[0]), bounds(list[1]), kTolerance), set.index);
  EXPECT_TRUE(clusters.crowded);
  EXPECT_EQ(subdivide(clusters, pair(floor, ceiling), set.index, kTolerance).count, 8u);
}

TEST(Tube, BothSidesOfASurfaceAreOneBlocker) {
  auto list = room();
  list.push_back(plate(1, 2, 1));
  Polygon back = plate(1, 2, 1);
  std::reverse(back.begin(), back.end());
  list.push_back(back);
  list.push_back(plate(1, 2, 1.5));  // the same plane, not the same corners
  const WorkingSet set(list);
  const Tube tube = make_tube(pair(list[0], list[1]), set.index, kTolerance);
  std::vector<std::uint32_t> found(tube.list().begin(), tube.list().end());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<std::uint32_t>{6, 8}));
}

TEST(Tube, WhatIsSettledIsInherited) {
  const WorkingSet empty(std::vector<Polygon>{});
  const auto list = room();
  Tube open = make_tube(pair(list[0], list[1]), empty.index, kTolerance);
  EXPECT_EQ(variety(open, pair(list[0], list[1]), empty.index, kTolerance), Variety::VISIBLE);
  // Not even looked at again: this working set would say otherwise.
  auto blocked = list;
  blocked.push_back(plate(-1, 5, 4));
  const WorkingSet set(blocked);
  Tube child = subdivide(open, pair(list[0], list[1]), set.index, kTolerance);
  EXPECT_EQ(variety(child, pair(list[0], list[1]), set.index, kTolerance), Variety::VISIBLE);
}

}  // namespace
}  // namespace atrium
