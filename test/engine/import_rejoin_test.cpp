#include <cmath>

#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

// A grid of n × n squares, each of two triangles, their diagonals alternating.
void triangulated_grid(ObjText& text, int n, double size, double z = 0) {
  const double h = size / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Vec3 a{i * h, j * h, z}, b{(i + 1) * h, j * h, z}, c{(i + 1) * h, (j + 1) * h, z},
          d{i * h, (j + 1) * h, z};
      if ((i + j) % 2 == 0)
        text.face({a, b, c}).face({a, c, d});
      else
        text.face({a, b, d}).face({b, c, d});
    }
}

class ImportRejoin : public ImportTest {};

TEST_F(ImportRejoin, ATriangulatedGridIsOneQuad) {
  ObjText text;
  text.object("x");
  triangulated_grid(text, 7, 3.5);
  const Scene scene = imported(text);
  ASSERT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.surfaces[0].vertex_count, 4u);
  EXPECT_NEAR(area_of(scene, kFront), 3.5 * 3.5, 1e-9);
  EXPECT_EQ(scene.polygons, 98u);
  EXPECT_EQ(scene.patches, 1u);
}

TEST_F(ImportRejoin, ATriangulatedLIsTwoRectangles) {
  // Fanned from a far corner, so that no merging of triangles alone finds rectangles.
  const Vec3 p[] = {{0, 0, 0}, {5, 0, 0}, {5, 1, 0}, {2, 1, 0}, {2, 4, 0}, {0, 4, 0}};
  const Scene scene = imported(ObjText()
                                   .object("x")
                                   .face({p[0], p[1], p[2]})
                                   .face({p[0], p[2], p[3]})
                                   .face({p[0], p[3], p[4]})
                                   .face({p[0], p[4], p[5]}));
  expect_sound(scene);
  ASSERT_EQ(scene.surfaces.size(), 2u);
  for (const Surface& s : scene.surfaces) {
    const PolygonView q = scene.polygon(s);
    ASSERT_EQ(q.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_NEAR(dot(q[(i + 1) % 4] - q[i], q[(i + 2) % 4] - q[(i + 1) % 4]), 0, 1e-12);
  }
  EXPECT_NEAR(area_of(scene, kFront), 5 + 6, 1e-12);
}

TEST_F(ImportRejoin, TJunctionsWithinAnObjectJoin) {
  // One long rectangle below, two short ones above: the long edge has a corner of theirs inside.
  const Scene scene =
      imported(ObjText().object("x").floor(0, 0, 4, 1).floor(0, 1, 1.5, 2).floor(1.5, 1, 4, 2));
  ASSERT_EQ(scene.surfaces.size(), 1u);
  EXPECT_NEAR(area_of(scene, kFront), 8, 1e-12);
}

TEST_F(ImportRejoin, ConvexPiecesThatCannotBeFewerStayAsTheyAre) {
  const Scene scene = imported(ObjText().object("x").floor(0, 0, 4, 1).floor(0, 1, 1, 3));
  ASSERT_EQ(scene.surfaces.size(), 2u);
  EXPECT_NEAR(area(scene.polygon(scene.surfaces[0])), 4, 1e-12);
  EXPECT_NEAR(area(scene.polygon(scene.surfaces[1])), 2, 1e-12);
}

TEST_F(ImportRejoin, ObjectsMaterialsAndOrientationsKeepFacesApart) {
  EXPECT_EQ(imported(ObjText().object("a").floor(0, 0, 1, 1).object("b").floor(1, 0, 2, 1)).patches,
            2u);
  EXPECT_EQ(
      imported(
          ObjText().object("a").material("m").floor(0, 0, 1, 1).material("n").floor(1, 0, 2, 1))
          .patches,
      2u);
  EXPECT_EQ(imported(ObjText().object("a").floor(0, 0, 1, 1).floor(1, 0, 2, 1, 0, false)).patches,
            2u);
  EXPECT_EQ(imported(ObjText().object("a").floor(0, 0, 1, 1).floor(1, 0, 2, 1)).patches, 1u);
}

TEST_F(ImportRejoin, FacesAtAnAngleStayApart) {
  // 0.1 mm of rise over a metre: ten times the tolerance of a scene of this size.
  const Scene scene = imported(ObjText()
                                   .object("x")
                                   .floor(0, 0, 1, 1)
                                   .face({{1, 0, 0}, {2, 0, 1e-4}, {2, 1, 1e-4}, {1, 1, 0}}));
  EXPECT_EQ(scene.patches, 2u);
}

TEST_F(ImportRejoin, AFrameWithAHoleIsFourRectangles) {
  ObjText text;
  text.object("x");
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != 1 || j != 1) text.floor(i, j, i + 1, j + 1);
  const Scene scene = imported(text);
  expect_sound(scene);
  EXPECT_EQ(scene.surfaces.size(), 4u);
  EXPECT_NEAR(area_of(scene, kFront), 8, 1e-12);
}

TEST_F(ImportRejoin, NeighboursShareCornersBitForBit) {
  // A box of triangulated sides, turned so that nothing is round: every corner is one point.
  ObjText text;
  text.object("x");
  const double c = std::cos(0.3), s = std::sin(0.3);
  const auto at = [&](double x, double y, double z) {
    return Vec3{c * x - s * y, s * x + c * y, z};
  };
  const Vec3 p[] = {at(0, 0, 0), at(3, 0, 0), at(3, 2, 0), at(0, 2, 0),
                    at(0, 0, 1), at(3, 0, 1), at(3, 2, 1), at(0, 2, 1)};
  constexpr int kSides[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
  for (const auto& q : kSides)
    text.face({p[q[0]], p[q[1]], p[q[2]]}).face({p[q[0]], p[q[2]], p[q[3]]});
  const Scene scene = imported(text);
  ASSERT_EQ(scene.surfaces.size(), 6u);
  for (const Surface& f : scene.surfaces) {
    ASSERT_EQ(f.vertex_count, 4u);
    EXPECT_EQ(f.sides, kFront);
    for (const Vec3& x : scene.polygon(f))
      EXPECT_TRUE(std::any_of(std::begin(p), std::end(p), [&](const Vec3& y) { return x == y; }));
  }
}

TEST_F(ImportRejoin, FacesFoldedOverOthersAreKept) {
  // Three triangles on one edge in one plane: half-edges cannot hold the third.
  const Scene scene = imported(ObjText()
                                   .object("x")
                                   .face({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})
                                   .face({{1, 0, 0}, {0, 0, 0}, {0, -1, 0}})
                                   .face({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}));
  expect_sound(scene);
  // What the third covers of the first is cut off; the union is left: 1/2 + 1/2 + 1/4.
  EXPECT_NEAR(area_of(scene, kFront), 1.25, 1e-9);
}

TEST_F(ImportRejoin, ACornerNearBothEdgesOfATipDoesNotPinchIt) {
  // A tip at the origin, an eighth of a radian wide, that its neighbour makes longer; and another
  // face's corner within tolerance of both edges of the tip.
  const Scene scene = imported(ObjText()
                                   .object("x")
                                   .face({{0, 0, 0}, {4, 0, 0}, {4, 0.5, 0}})
                                   .face({{4, 0, 0}, {6, 0, 0}, {4, 0.5, 0}})
                                   .face({{4e-6, 2.5e-7, 0}, {-1, 1, 0}, {-1, -1, 0}}));
  expect_sound(scene);
  EXPECT_EQ(scene.patches, 2u);
  EXPECT_NEAR(area_of(scene, kFront), 1 + 0.5 + 1, 1e-5);
}

class ImportScales : public ImportTest,
                     public testing::WithParamInterface<std::pair<double, double>> {};

// A room with a triangulated floor, an L-shaped wall, a box and a carpet: the same patches and
// surfaces at any size and place.
TEST_P(ImportScales, ScaleAndPlaceDoNotMatter) {
  const auto build = [](ObjText& text) -> ObjText& {
    text.object("floor");
    triangulated_grid(text, 5, 4);
    text.object("wall").face({{0, 0, 0}, {0, 4, 0}, {0, 4, 1}, {0, 2, 1}, {0, 2, 3}, {0, 0, 3}});
    text.object("box").box({1, 1, 0}, {2, 2, 1});
    text.object("carpet").floor(2.5, 2.5, 3.7, 3.7, 0, true);
    text.object("bent").face({{3, 0, 1}, {4, 0, 1.2}, {4, 1, 1}, {3, 1, 1.2}});
    return text;
  };
  ObjText plain;
  const Scene here = imported(build(plain));
  const auto [scale, shift] = GetParam();
  ObjText moved;
  moved.scale = scale;
  moved.shift = Vec3{shift, -0.5 * shift, 0.25 * shift};
  const Scene there = imported(build(moved));
  EXPECT_EQ(there.patches, here.patches);
  EXPECT_EQ(there.surfaces.size(), here.surfaces.size());
  EXPECT_EQ(there.objects.size(), here.objects.size());
  EXPECT_EQ(there.warnings.size(), here.warnings.size());
  EXPECT_NEAR(area_of(there, kFront) / (scale * scale), area_of(here, kFront), 1e-6);
  EXPECT_NEAR(area_of(there, kBack) / (scale * scale), area_of(here, kBack), 1e-6);
  expect_sound(there);
}

INSTANTIATE_TEST_SUITE_P(Sizes, ImportScales,
                         testing::Values(std::pair(1e-6, 0.0), std::pair(1e6, 0.0),
                                         std::pair(1.0, 1e6), std::pair(1.0, -1e6),
                                         std::pair(1e-6, 1e-3), std::pair(1e3, 1e6)));

}  // namespace
}  // namespace atrium
