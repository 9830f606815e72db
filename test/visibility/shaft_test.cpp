#include "visibility/shaft.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "visibility/blocker.h"

namespace atrium {
namespace {

constexpr double kTolerance = 1e-6;  // m, of scenes some metres wide

struct Dice {
  std::mt19937 engine;
  double unit() { return std::uniform_real_distribution<double>(0, 1)(engine); }
  Vec3 in_cube(double size) { return size * Vec3{unit(), unit(), unit()}; }
  Vec3 direction() {
    std::normal_distribution<double> g;
    return normalize(Vec3{g(engine), g(engine), g(engine)});
  }
  // A convex polygon of 3 to `most` corners on a circle.
  Polygon polygon(const Vec3& center, double radius, int most = 6) {
    const Vec3 n = direction();
    const Vec3 u = normalize(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    const int corners = 3 + int((most - 2) * unit());
    Polygon out;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * M_PI * (k + 0.6 * unit()) / corners;
      out.push_back(center + radius * (std::cos(angle) * u + std::sin(angle) * cross(n, u)));
    }
    return out;
  }
  Vec3 on(const Polygon& polygon) {
    const std::size_t i = 2 + std::size_t(unit() * double(polygon.size() - 2));
    const double a = std::sqrt(unit()), b = unit();
    return (1 - a) * polygon[0] + a * ((1 - b) * polygon[i - 1] + b * polygon[i]);
  }
};

bool crosses(PolygonView polygon, const Vec3& from, const Vec3& to) {
  const Plane plane = plane_of(polygon);
  const double a = plane.distance(from), b = plane.distance(to);
  if (!(a * b < 0)) return false;
  return contains(polygon, plane.normal, from + (to - from) * (a / (a - b)), 0);
}

Shaft shaft_of(const Polygon& p, const Polygon& q, double tolerance = kTolerance) {
  return make_shaft(p, plane_of(p).normal, q, plane_of(q).normal, tolerance);
}

class AtScaleAndOffset : public testing::TestWithParam<std::pair<double, double>> {};

// Random rays between what p and q see of each other: if one of them is blocked deep enough, the
// shaft must have named the blocker.
TEST_P(AtScaleAndOffset, NeverMissesWhatBlocksARay) {
  const auto [scale, offset] = GetParam();
  const Vec3 move = offset * Vec3{1, -0.5, 0.25};
  const auto placed = [&](Polygon p) {
    for (Vec3& x : p) x = x * scale + move;
    return p;
  };
  Dice dice{std::mt19937(17)};
  int open = 0, witnessed = 0, named = 0, trials = 0;
  for (int scene = 0; scene < 3000; ++scene) {
    const Polygon p = placed(dice.polygon(dice.in_cube(4), 0.3 + dice.unit(), 20));
    const Polygon q = placed(dice.polygon(dice.in_cube(4), 0.3 + dice.unit()));
    const Shaft shaft = shaft_of(p, q, kTolerance * scale);
    const Plane plane_p = plane_of(p), plane_q = plane_of(q);
    open += !shaft.closed;
    for (int k = 0; k < 10; ++k) {
      const Polygon blocker = placed(dice.polygon(dice.in_cube(4), 0.2 + dice.unit()));
      const bool may = may_block(shaft, blocker);
      bool blocks = false;
      for (int ray = 0; ray < (may ? 400 : 60) && !blocks; ++ray) {
        const Vec3 x = dice.on(p), y = dice.on(q);
        // Light only passes from front to front; a margin for the depth.
        const double margin = 3e-5 * scale;
        if (plane_p.distance(y) < margin || plane_q.distance(x) < margin) continue;
        blocks = crosses(blocker, x, y);
      }
      ++trials;
      witnessed += blocks;
      named += may;
      EXPECT_TRUE(may || !blocks) << "scene " << scene << ", blocker " << k;
    }
  }
  // Neither always yes nor without cases: few of those named go without a blocked ray.
  EXPECT_GT(open, 800);
  EXPECT_GT(witnessed, 800);
  EXPECT_LT(named, 0.5 * trials);
  EXPECT_LT(named, 1.5 * witnessed);
}

INSTANTIATE_TEST_SUITE_P(Shaft, AtScaleAndOffset,
                         testing::Values(std::pair{1.0, 0.0}, std::pair{1e-6, 0.0},
                                         std::pair{1.0, 1e6}));

TEST(Shaft, OfBoxesNeverMissesWhatBlocksARay) {
  Dice dice{std::mt19937(23)};
  int witnessed = 0, named = 0;
  for (int scene = 0; scene < 2000; ++scene) {
    Box p, q;
    for (Box* b : {&p, &q}) {
      const Vec3 corner = dice.in_cube(4);
      b->extend(corner);
      b->extend(corner + dice.in_cube(1));
    }
    const auto in = [&](const Box& b) { return b.lo + b.extent() * dice.in_cube(1); };
    const Shaft shaft = make_shaft(p, q, kTolerance);
    for (int k = 0; k < 10; ++k) {
      const Polygon blocker = dice.polygon(dice.in_cube(5), 0.2 + dice.unit());
      const bool may = may_block(shaft, blocker);
      bool blocks = false;
      for (int ray = 0; ray < (may ? 400 : 60) && !blocks; ++ray)
        blocks = crosses(blocker, in(p), in(q));
      witnessed += blocks;
      named += may;
      EXPECT_TRUE(may || !blocks) << "scene " << scene << ", blocker " << k;
    }
  }
  EXPECT_GT(witnessed, 800);
  EXPECT_LT(named, 1.7 * witnessed);
}

// What cannot reach into the hull of two facing squares a metre apart, and what just does.
TEST(Shaft, TouchingIsNotBlocking) {
  const Polygon floor{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Polygon ceiling{{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
  const Shaft shaft = shaft_of(floor, ceiling);
  ASSERT_FALSE(shaft.closed);
  EXPECT_FALSE(may_block(shaft, floor));
  EXPECT_FALSE(may_block(shaft, ceiling));
  EXPECT_FALSE(may_block(shaft, Polygon{{-5, -5, 0}, {5, -5, 0}, {5, 5, 0}, {-5, 5, 0}}));
  const auto wall = [](double x) {
    return Polygon{{x, -1, -1}, {x, 2, -1}, {x, 2, 2}, {x, -1, 2}};
  };
  EXPECT_FALSE(may_block(shaft, wall(0)));
  EXPECT_FALSE(may_block(shaft, wall(1)));
  EXPECT_FALSE(may_block(shaft, wall(0.5 * kTolerance)));
  EXPECT_TRUE(may_block(shaft, wall(2 * kTolerance)));
  EXPECT_TRUE(may_block(shaft, wall(1 - 2 * kTolerance)));
  // Leaning against the hull's vertical edge from outside, and reaching in past it.
  EXPECT_FALSE(may_block(shaft, Polygon{{-1, 1, 0}, {1, -1, 0}, {1, -1, 1}, {-1, 1, 1}}));
  EXPECT_TRUE(
      may_block(shaft, Polygon{{-1, 1.01, 0}, {1.01, -1, 0}, {1.01, -1, 1}, {-1, 1.01, 1}}));
}

TEST(Shaft, FacingAwayOrCoplanarIsClosed) {
  const Polygon up{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Polygon beside{{2, 0, 0}, {3, 0, 0}, {3, 1, 0}, {2, 1, 0}};
  const Polygon above{{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};  // looks up as well
  EXPECT_TRUE(shaft_of(up, beside).closed);
  EXPECT_TRUE(shaft_of(up, above).closed);
  EXPECT_TRUE(shaft_of(up, up).closed);
}

// A wall that passes through the floor: only its upper half can exchange light with the floor.
TEST(Shaft, OnlyWhatIsInFrontCounts) {
  const Polygon floor{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Polygon wall{{0, 0, -1}, {0, 1, -1}, {0, 1, 1}, {0, 0, 1}};  // looks to +x
  const Shaft shaft = shaft_of(floor, wall);
  ASSERT_FALSE(shaft.closed);
  EXPECT_FALSE(may_block(shaft, Polygon{{0.2, 0, -0.9}, {0.2, 1, -0.9}, {0.2, 1, 0}, {0.2, 0, 0}}));
  EXPECT_TRUE(
      may_block(shaft, Polygon{{0.2, 0, -0.9}, {0.2, 1, -0.9}, {0.2, 1, 0.1}, {0.2, 0, 0.1}}));
}

TEST(Shaft, APlateBetweenBlocksAll) {
  const Polygon floor{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const Polygon ceiling{{0, 0, 2}, {0, 1, 2}, {1, 1, 2}, {1, 0, 2}};
  const auto plate = [](double from, double to) {
    return Polygon{{from, from, 1}, {to, from, 1}, {to, to, 1}, {from, to, 1}};
  };
  EXPECT_TRUE(blocks_all(floor, ceiling, plate(-0.1, 1.1), kTolerance));
  EXPECT_TRUE(blocks_all(ceiling, floor, plate(-0.1, 1.1), kTolerance));
  EXPECT_TRUE(blocks_all(floor, ceiling, plate(0, 1), kTolerance));
  EXPECT_FALSE(blocks_all(floor, ceiling, plate(-0.1, 0.99), kTolerance));
  EXPECT_FALSE(blocks_all(floor, ceiling, floor, kTolerance));
  EXPECT_FALSE(blocks_all(floor, ceiling, Polygon{{-1, -1, 3}, {2, -1, 3}, {2, 2, 3}, {-1, 2, 3}},
                          kTolerance));
}

// A partition that stands on the floor's edge hides the ceiling beyond it wholly.
TEST(Shaft, APartitionOnTheEdgeBlocksAll) {
  const Polygon floor{{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}, {-1, 1, 0}};
  const Polygon ceiling{{0, 0, 2}, {0, 1, 2}, {1, 1, 2}, {1, 0, 2}};
  const Polygon wall{{0, 0, 0}, {0, 1, 0}, {0, 1, 2}, {0, 0, 2}};
  EXPECT_FALSE(blocks_all(floor, ceiling, Polygon{{0, 0, 0}, {0, 1, 0}, {0, 1, 1.9}, {0, 0, 1.9}},
                          kTolerance));
  EXPECT_TRUE(blocks_all(floor, ceiling, wall, kTolerance));
}

TEST(Shaft, BlocksAllMeansEveryRay) {
  Dice dice{std::mt19937(31)};
  int all = 0;
  for (int i = 0; i < 20000; ++i) {
    const Polygon p = dice.polygon({0, 0, 0}, 0.3), q = dice.polygon({0, 0, 3}, 0.3);
    const Polygon blocker = dice.polygon(dice.in_cube(0.5) + Vec3{0, 0, 1.2}, 2 * dice.unit());
    if (!blocks_all(p, q, blocker, 1e-12)) continue;
    ++all;
    for (int ray = 0; ray < 30; ++ray) EXPECT_TRUE(crosses(blocker, dice.on(p), dice.on(q)));
  }
  EXPECT_GT(all, 500);
}

// The index names exactly the blockers that the test alone names, in one order.
TEST(BlockerIndex, CollectsWhatTheTestAloneNames) {
  Dice dice{std::mt19937(41)};
  std::vector<Polygon> polygons;
  for (int i = 0; i < 700; ++i) polygons.push_back(dice.polygon(dice.in_cube(10), 0.5));
  std::vector<BlockerPolygon> blockers;
  for (std::size_t i = 0; i < polygons.size(); ++i)
    blockers.push_back({polygons[i], std::uint32_t(i)});
  const BlockerIndex index(blockers), again(blockers);
  std::size_t total = 0;
  for (int i = 0; i < 300; ++i) {
    const Shaft shaft =
        i % 2 ? shaft_of(dice.polygon(dice.in_cube(10), 1), dice.polygon(dice.in_cube(10), 1))
              : make_shaft(bounds(dice.polygon(dice.in_cube(10), 1)),
                           bounds(dice.polygon(dice.in_cube(10), 1)), kTolerance);
    std::vector<std::uint32_t> expected, found(polygons.size()), found_again(polygons.size());
    for (std::uint32_t k = 0; k < polygons.size(); ++k)
      if (may_block(shaft, polygons[k])) expected.push_back(k);
    const auto count = index.collect(shaft, found);
    ASSERT_TRUE(count);
    found.resize(*count);
    found_again.resize(*again.collect(shaft, found_again));
    EXPECT_EQ(found, found_again);
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);
    total += expected.size();
    if (expected.empty()) continue;
    std::vector<std::uint32_t> short_by_one(expected.size() - 1);
    EXPECT_FALSE(index.collect(shaft, short_by_one));
  }
  EXPECT_GT(total, 1000u);
}

}  // namespace
}  // namespace atrium
