// Frames, and the unit square taken to directions and polygons.
#include "engine/geometry.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

constexpr double kRounding = 1e-12;

// Both poles, where the frame's formula changes sign, and what is next to them.
TEST(FrameAbout, IsOrthonormalAndRightHandedAboutAnyNormal) {
  for (const Vec3& along : {Vec3{0, 0, 1}, Vec3{0, 0, -1}, Vec3{1, 0, 0}, Vec3{0, -1, 0},
                            Vec3{1, -2, 3}, Vec3{1, 2, -3}, Vec3{1e-9, 0, -1}, Vec3{1, 1, -0.0}}) {
    const Vec3 n = normalize(along);
    const Frame f = frame_about(n);
    EXPECT_EQ(f.n, n);
    EXPECT_NEAR(length(f.u), 1, kRounding);
    EXPECT_NEAR(length(cross(f.u, f.v) - n), 0, kRounding);
    EXPECT_NEAR(dot(f.u, n), 0, kRounding);
    EXPECT_NEAR(dot(f.u, f.v), 0, kRounding);
  }
}

// Calls `visit` at the centres of side × side equal squares of the unit square.
template <class Visit>
void each_square(int side, const Visit& visit) {
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) visit(Vec2{(i + 0.5) / side, (j + 0.5) / side});
}

// The cosine's mean under cos/π is 2/3, its square's 1/2, and both tangents' means are 0.
TEST(CosineDirection, HasTheCosinesMoments) {
  constexpr int kSide = 200;
  const Frame f = frame_about(normalize(Vec3{1, -2, 3}));
  Vec3 mean{0};
  double square = 0;
  each_square(kSide, [&](const Vec2& p) {
    const Vec3 d = cosine_direction(f, p);
    EXPECT_NEAR(length(d), 1, kRounding);
    mean += f.to_frame(d) / double(kSide * kSide);
    square += dot(d, f.n) * dot(d, f.n) / (kSide * kSide);
  });
  EXPECT_NEAR(mean.x, 0, kRounding);
  EXPECT_NEAR(mean.y, 0, kRounding);
  EXPECT_NEAR(mean.z, 2.0 / 3, 1e-3);  // the midpoint rule of a root
  EXPECT_NEAR(square, 0.5, kRounding);
}

// Each part of a polygon gets as many points as it has area, across the triangles of the fan.
TEST(PointOf, FillsAPolygonByArea) {
  constexpr int kSide = 300;
  const Polygon house{{0, 0, 1}, {4, 0, 1}, {4, 2, 1}, {2, 4, 1}, {0, 2, 1}};  // 8 + 4 m²
  int above = 0;
  Vec3 mean{0};
  each_square(kSide, [&](const Vec2& p) {
    const Vec3 x = point_of(house, p);
    EXPECT_TRUE(contains(house, {0, 0, 1}, x, kRounding));
    EXPECT_EQ(x.z, 1);
    above += x.y > 2;
    mean += x / double(kSide * kSide);
  });
  EXPECT_NEAR(above / double(kSide * kSide), 4.0 / 12, 2.0 / kSide);  // its border crosses squares
  EXPECT_NEAR(length(mean - centroid(house)), 0, 2e-3);
}

TEST(PointOf, CornersOfTheSquareAreCornersOfTheTriangle) {
  const Polygon t{{1, 2, 3}, {4, 2, 3}, {1, 7, 5}};
  for (const double y : {0.0, 0.5, 1.0}) EXPECT_EQ(point_of(t, {0, y}), t[0]);
  EXPECT_NEAR(length(point_of(t, {1, 0}) - t[1]), 0, kRounding);
  EXPECT_NEAR(length(point_of(t, {1, 1}) - t[2]), 0, kRounding);
}

// A fan whose first and last triangles are flat.
TEST(PointOf, TrianglesWithoutAreaGetNone) {
  const Polygon t{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 1, 0}};
  Vec3 mean{0};
  constexpr int kSide = 100;
  each_square(kSide, [&](const Vec2& p) { mean += point_of(t, p) / double(kSide * kSide); });
  EXPECT_NEAR(length(mean - Vec3{2.0 / 3, 2.0 / 3, 0}), 0, 1e-3);
}

}  // namespace
}  // namespace atrium
