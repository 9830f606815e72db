#include "engine/import/convex_pieces.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace atrium {
namespace {

constexpr double kTolerance = 1e-6, kSlack = 1e-6;

struct Cut {
  std::vector<Vec2> points;
  std::vector<Ring> loops;
  std::optional<std::vector<Ring>> pieces;

  void add(const std::vector<Vec2>& loop) {
    Ring ring(loop.size());
    std::iota(ring.begin(), ring.end(), static_cast<std::uint32_t>(points.size()));
    points.insert(points.end(), loop.begin(), loop.end());
    loops.push_back(ring);
  }
  void run() { pieces = convex_pieces(points, loops, kTolerance, kSlack); }
  void expect_cover(double area, std::size_t most_pieces) const {
    ASSERT_TRUE(pieces.has_value());
    EXPECT_LE(pieces->size(), most_pieces);
    double sum = 0;
    for (const Ring& r : *pieces) {
      sum += signed_area(points, r);
      for (std::size_t i = 0; i < r.size(); ++i) {
        const Vec2 a = points[r[i]], b = points[r[(i + 1) % r.size()]],
                   c = points[r[(i + 2) % r.size()]];
        EXPECT_GE(perp(b - a, c - b), -kTolerance);
      }
    }
    EXPECT_NEAR(sum, area, kSlack);
  }
};

std::vector<Vec2> rectangle(double x0, double y0, double x1, double y1) {
  return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
}
std::vector<Vec2> reversed(std::vector<Vec2> loop) { return {loop.rbegin(), loop.rend()}; }

TEST(ConvexPieces, AConvexLoopStaysWhole) {
  Cut cut;
  cut.add(rectangle(0, 0, 2, 1));
  cut.run();
  cut.expect_cover(2, 1);
}

TEST(ConvexPieces, ACrossOfTwelveCornersIsThreeRectangles) {
  Cut cut;
  cut.add({{1, 0},
           {2, 0},
           {2, 1},
           {3, 1},
           {3, 2},
           {2, 2},
           {2, 3},
           {1, 3},
           {1, 2},
           {0, 2},
           {0, 1},
           {1, 1}});
  cut.run();
  cut.expect_cover(5, 3);
}

TEST(ConvexPieces, AStairOfRectanglesHasOnePieceAStep) {
  Cut cut;
  std::vector<Vec2> stair{{0, 0}};
  constexpr int kSteps = 12;
  for (int i = 0; i < kSteps; ++i) {
    stair.push_back({double(kSteps - i), double(i)});
    stair.push_back({double(kSteps - i), double(i + 1)});
  }
  stair.push_back({0, kSteps});
  cut.add(stair);
  cut.run();
  cut.expect_cover(kSteps * (kSteps + 1) / 2, kSteps);
}

TEST(ConvexPieces, WindowsInAWall) {
  // With h holes of r = 4h reflex corners: at most r + 1 - h pieces, fewer where cuts join holes.
  Cut cut;
  cut.add(rectangle(0, 0, 20, 3));
  for (int i = 0; i < 6; ++i) cut.add(reversed(rectangle(1 + 3 * i, 1, 2.5 + 3 * i, 2)));
  cut.run();
  cut.expect_cover(60 - 6 * 1.5, 4 * 6 + 1 - 6);
}

TEST(ConvexPieces, ARoundHole) {
  Cut cut;
  cut.add(rectangle(-2, -2, 2, 2));
  std::vector<Vec2> round;
  constexpr int kCorners = 24;
  for (int k = 0; k < kCorners; ++k)
    round.push_back({std::cos(2 * kPi * k / kCorners), std::sin(2 * kPi * k / kCorners)});
  cut.add(reversed(round));
  cut.run();
  const double polygon = 0.5 * kCorners * std::sin(2 * kPi / kCorners);
  cut.expect_cover(16 - polygon, kCorners);
}

TEST(ConvexPieces, AHoleThatTouchesTheOutline) {
  Cut cut;
  cut.add(rectangle(0, 0, 4, 4));
  cut.add(reversed({{2, 0}, {3, 1}, {2, 2}, {1, 1}}));  // a corner on the lower edge
  cut.run();
  cut.expect_cover(16 - 2, 5);
}

TEST(ConvexPieces, HolesThatTouchEachOther) {
  Cut cut;
  cut.add(rectangle(0, 0, 6, 4));
  cut.add(reversed(rectangle(1, 1, 3, 2)));
  cut.add(reversed(rectangle(3, 2, 5, 3)));
  cut.run();
  cut.expect_cover(24 - 4, 8);
}

TEST(ConvexPieces, ANeckNarrowerThanTheTolerance) {
  Cut cut;
  cut.add(rectangle(0, 0, 4, 4));
  cut.add(reversed(rectangle(1, 0.2 * kTolerance, 2, 1)));
  cut.run();
  cut.expect_cover(16 - 1, 3);
}

TEST(ConvexPieces, RandomRectilinearRegionsAreCovered) {
  unsigned state = 7;
  const auto random = [&](unsigned n) {
    state = state * 1664525u + 1013904223u;
    return (state >> 16) % n;
  };
  for (int trial = 0; trial < 60; ++trial) {
    // Cells of a grid switched on at random; their outlines by cancelling.
    constexpr unsigned kSize = 7;
    Cut cut;
    for (unsigned y = 0; y <= kSize; ++y)
      for (unsigned x = 0; x <= kSize; ++x) cut.points.push_back({double(x), double(y)});
    std::vector<Ring> cells;
    const unsigned step = kSize + 1;
    for (unsigned y = 0; y < kSize; ++y)
      for (unsigned x = 0; x < kSize; ++x)
        if (random(3) > 0) {
          const unsigned i = y * step + x;
          cells.push_back({i, i + 1, i + 1 + step, i + step});
        }
    cut.loops = cancelled_loops(cut.points, cells);
    cut.run();
    cut.expect_cover(static_cast<double>(cells.size()), cells.size());
  }
}

TEST(ConvexPieces, RandomStarsAreCovered) {
  unsigned state = 11;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return (state >> 8) / double(1u << 24);
  };
  for (int trial = 0; trial < 100; ++trial) {
    Cut cut;
    std::vector<Vec2> star;
    const int n = 5 + trial % 40;
    for (int k = 0; k < n; ++k) {
      const double r = 0.2 + random(), a = 2 * kPi * k / n;
      star.push_back({r * std::cos(a), r * std::sin(a)});
    }
    cut.add(star);
    const double expected = signed_area(cut.points, cut.loops[0]);
    std::size_t reflex = 0;
    for (int k = 0; k < n; ++k) {
      const auto at = [&](int i) { return star[static_cast<std::size_t>((i + n) % n)]; };
      reflex += perp(at(k) - at(k - 1), at(k + 1) - at(k)) < 0;
    }
    cut.run();
    cut.expect_cover(expected, reflex + 1);
  }
}

TEST(WithoutCollinear, KeepsCornersAndOnlyThose) {
  const std::vector<Vec2> points{{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2 + 1e-9}, {0, 2}, {0, 1}};
  EXPECT_EQ(without_collinear(points, {0, 1, 2, 3, 4, 5, 6}, kTolerance).size(), 4u);
}

TEST(CancelledLoops, AKeyholeBecomesOutlineAndHole) {
  const std::vector<Vec2> points{{0, 0}, {4, 0}, {4, 4}, {0, 4}, {1, 1}, {1, 3}, {3, 3}, {3, 1}};
  const Ring keyhole{0, 1, 2, 3, 0, 4, 5, 6, 7, 4};
  const auto loops = cancelled_loops(points, std::vector<Ring>{keyhole});
  ASSERT_EQ(loops.size(), 2u);
  EXPECT_EQ(signed_area(points, loops[0]) + signed_area(points, loops[1]), 16 - 4);
}

}  // namespace
}  // namespace atrium
