#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

class ImportOverlap : public ImportTest {
 protected:
  void SetUp() override {
    ImportTest::SetUp();
    write("m.mtl", "newmtl grey\nKd 0.5\nnewmtl lamp\nKd 0\nKe 500\n");
    options_.sides = SidesChoice::kOne;
  }
  Scene with_materials(const ObjText& text) {
    return imported("mtllib m.mtl\n" + std::string(text));
  }

  // m² of an object's surfaces on which the side counts.
  static double area_of_object(const Scene& scene, const std::string& name, Sides side) {
    double sum = 0;
    for (const Surface& s : scene.surfaces)
      if (scene.objects[s.object.value].name == name && (s.sides & side))
        sum += area(scene.polygon(s));
    return sum;
  }
};

TEST_F(ImportOverlap, TheFirstInTheFilesCounts) {
  const Scene scene = with_materials(
      ObjText().object("floor").floor(0, 0, 4, 4).object("carpet").floor(1, 1, 3, 5));
  expect_sound(scene);
  EXPECT_NEAR(area_of_object(scene, "floor", kFront), 16, 1e-9);
  EXPECT_NEAR(area_of_object(scene, "carpet", kFront), 2 * 1, 1e-9);
  EXPECT_EQ(scene.patches, 2u);
  EXPECT_EQ(warning(scene, "the part that does not count")->count, 1u);
}

TEST_F(ImportOverlap, WholeDuplicatesVanish) {
  const Scene scene = with_materials(ObjText()
                                         .object("a")
                                         .floor(0, 0, 4, 4)
                                         .object("b")
                                         .floor(0, 0, 4, 4)
                                         .object("c")
                                         .floor(1, 1, 2, 2));
  EXPECT_EQ(scene.surfaces.size(), 1u);
  EXPECT_EQ(scene.patches, 1u);
  EXPECT_EQ(warning(scene, "wholly covered")->count, 2u);
  const Scene same = with_materials(ObjText().object("a").floor(0, 0, 4, 4).floor(0, 0, 4, 4));
  EXPECT_EQ(same.surfaces.size(), 1u);
  EXPECT_EQ(warning(same, "duplicate faces")->count, 1u);
}

TEST_F(ImportOverlap, TheEmitterCountsBeforeTheFirst) {
  const Scene scene = with_materials(ObjText()
                                         .object("ceiling")
                                         .material("grey")
                                         .floor(0, 0, 4, 4)
                                         .object("panel")
                                         .material("lamp")
                                         .floor(1, 1, 2, 3));
  expect_sound(scene);
  EXPECT_NEAR(area_of_object(scene, "panel", kFront), 2, 1e-12);
  EXPECT_NEAR(area_of_object(scene, "ceiling", kFront), 14, 1e-9);
  EXPECT_EQ(scene.lights, 1u);
  // Around one rectangular hole four pieces are the fewest.
  EXPECT_EQ(scene.surfaces.size(), 5u);
  const Scene twin = with_materials(
      ObjText().object("a").material("grey").floor(0, 0, 4, 4).material("lamp").floor(0, 0, 4, 4));
  EXPECT_EQ(twin.lights, 1u);
  EXPECT_EQ(twin.surfaces.size(), 1u);
}

TEST_F(ImportOverlap, OppositeFrontsBothCount) {
  const Scene scene = with_materials(
      ObjText().object("up").floor(0, 0, 4, 4).object("down").floor(1, 1, 3, 3, 0, false));
  EXPECT_NEAR(area_of_object(scene, "up", kFront), 16, 1e-12);
  EXPECT_NEAR(area_of_object(scene, "down", kFront), 4, 1e-12);
  EXPECT_EQ(scene.surfaces.size(), 2u);
}

TEST_F(ImportOverlap, AFrontCountsBeforeABackWhateverTheOrder) {
  options_.sides = SidesChoice::kTwo;
  for (const bool swapped : {false, true}) {
    ObjText text;
    const auto up = [&] { text.object("up").floor(0, 0, 4, 4); };
    const auto down = [&] { text.object("down").floor(1, 1, 3, 5, 0, false); };
    swapped ? down() : up();
    swapped ? up() : down();
    const Scene scene = with_materials(text);
    expect_sound(scene);
    EXPECT_NEAR(area_of_object(scene, "up", kFront), 16, 1e-9);
    EXPECT_NEAR(area_of_object(scene, "up", kBack), 16 - 6, 1e-9);
    EXPECT_NEAR(area_of_object(scene, "down", kFront), 8, 1e-9);
    EXPECT_NEAR(area_of_object(scene, "down", kBack), 8 - 6, 1e-9);
    EXPECT_EQ(scene.patches, 2u);
  }
}

TEST_F(ImportOverlap, ABackLosesToTheFrontEvenOfADarkerFace) {
  // The lamp's back against the floor's front: front before back, then only the emitter.
  options_.sides = SidesChoice::kTwo;
  const Scene scene = with_materials(ObjText()
                                         .object("lamp")
                                         .material("lamp")
                                         .floor(0, 0, 1, 1, 0, false)
                                         .object("floor")
                                         .material("grey")
                                         .floor(0, 0, 1, 1));
  EXPECT_NEAR(area_of_object(scene, "lamp", kFront), 1, 1e-12);
  EXPECT_NEAR(area_of_object(scene, "lamp", kBack), 0, 1e-12);
  EXPECT_NEAR(area_of_object(scene, "floor", kFront), 1, 1e-12);
  EXPECT_NEAR(area_of_object(scene, "floor", kBack), 0, 1e-12);
}

TEST_F(ImportOverlap, NeighboursThatOnlyTouchAreNotCut) {
  const Scene scene = with_materials(ObjText()
                                         .object("a")
                                         .floor(0, 0, 1, 1)
                                         .object("b")
                                         .floor(1, 0, 2, 1)
                                         .object("c")
                                         .floor(0.5, 1, 1.5, 2)
                                         .object("above")
                                         .floor(0, 0, 1, 1, 0.001));
  EXPECT_EQ(scene.surfaces.size(), 4u);
  EXPECT_EQ(scene.warnings.size(), 1u) << "but for the default material nothing is wrong";
}

TEST_F(ImportOverlap, SlantedPlanesAndPartialOverlapsKeepTheUnionsArea) {
  // Two equal squares in a slanted plane, the second turned by 45 degrees about their centre: an
  // octagon is common. Union = 2 squares - octagon, the octagon of side s(sqrt2 - 1).
  const double r = std::sqrt(0.5);
  const Vec3 u{r, 0, r}, v{0, 1, 0}, centre{3, 2, 1};
  const auto square = [&](double angle) {
    std::vector<Vec3> corners;
    for (int k = 0; k < 4; ++k) {
      const double a = angle + k * std::acos(0.0);
      corners.push_back(centre + std::sqrt(2.0) * (std::cos(a) * u + std::sin(a) * v));
    }
    return corners;
  };
  const Scene scene = with_materials(
      ObjText().object("a").face(square(std::acos(0.0) / 2)).object("b").face(square(0)));
  expect_sound(scene);
  const double side = 2 * (std::sqrt(2.0) - 1);
  const double octagon = 2 * (1 + std::sqrt(2.0)) * side * side;
  EXPECT_NEAR(area_of(scene, kFront), 4 + 4 - octagon, 1e-6);
  EXPECT_NEAR(area_of_object(scene, "b", kFront), 4 - octagon, 1e-6);
  EXPECT_EQ(scene.surfaces.size(), 5u);
}

TEST_F(ImportOverlap, ManyRandomOverlapsCoverTheirUnionOnce) {
  // Rectangles on a grid of whole numbers: the union is countable by cells.
  constexpr int kSize = 24;
  std::vector<char> covered(kSize * kSize, 0);
  ObjText text;
  unsigned state = 12345;
  const auto random = [&](int n) {
    state = state * 1664525u + 1013904223u;
    return static_cast<int>((state >> 16) % static_cast<unsigned>(n));
  };
  for (int k = 0; k < 60; ++k) {
    const int x0 = random(kSize), y0 = random(kSize);
    const int x1 = x0 + 1 + random(std::min(6, kSize - x0));
    const int y1 = y0 + 1 + random(std::min(6, kSize - y0));
    text.object("r" + std::to_string(k)).floor(x0, y0, x1, y1);
    for (int x = x0; x < x1; ++x)
      for (int y = y0; y < y1; ++y) covered[static_cast<std::size_t>(x * kSize + y)] = 1;
  }
  double expected = 0;
  for (const char c : covered) expected += c;
  const Scene scene = with_materials(text);
  expect_sound(scene);
  EXPECT_NEAR(area_of(scene, kFront), expected, 1e-6);
  // Each cell's centre lies in exactly one surface, or in none.
  for (int x = 0; x < kSize; ++x)
    for (int y = 0; y < kSize; ++y) {
      int hits = 0;
      for (const Surface& s : scene.surfaces)
        hits += contains(scene.polygon(s), {0, 0, 1},
                         scene.frame.to_internal({x + 0.5, y + 0.5, 0}), 0);
      EXPECT_EQ(hits, covered[static_cast<std::size_t>(x * kSize + y)]);
    }
}

}  // namespace
}  // namespace atrium
