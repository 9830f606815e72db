#include "test/engine/import_fixture.h"

namespace atrium {
namespace {

class ImportSides : public ImportTest {
 protected:
  void SetUp() override {
    ImportTest::SetUp();
    write("m.mtl", "newmtl grey\nKd 0.5\nnewmtl lamp\nKd 0\nKe 500\n");
  }
  Scene with_materials(const ObjText& text) {
    return imported("mtllib m.mtl\n" + std::string(text));
  }
  // The sides that all surfaces of an object have, or kNoSide where they differ.
  static int sides_of(const Scene& scene, const std::string& name) {
    int sides = -1;
    for (const Surface& s : scene.surfaces)
      if (scene.objects[s.object.value].name == name) {
        if (sides >= 0 && sides != s.sides) return kNoSide;
        sides = s.sides;
      }
    return sides;
  }
};

TEST_F(ImportSides, SolidsShowTheirOutsideAndSheetsBoth) {
  const Scene scene = with_materials(
      ObjText().object("box").box({0, 0, 0}, {1, 1, 1}).object("sheet").floor(3, 3, 4, 4));
  EXPECT_EQ(sides_of(scene, "box"), kFront);
  EXPECT_EQ(sides_of(scene, "sheet"), kBothSides);
  EXPECT_EQ(warning(scene, "closed solids")->count, 6u);
  EXPECT_EQ(warning(scene, "open sheets")->count, 1u);
}

TEST_F(ImportSides, OneAndTwoAreTakenAtTheirWord) {
  ObjText text;
  text.object("box").box({0, 0, 0}, {1, 1, 1}).object("sheet").floor(3, 3, 4, 4);
  options_.sides = SidesChoice::kOne;
  Scene scene = with_materials(text);
  EXPECT_EQ(sides_of(scene, "box"), kFront);
  EXPECT_EQ(sides_of(scene, "sheet"), kFront);
  options_.sides = SidesChoice::kTwo;
  scene = with_materials(text);
  EXPECT_EQ(sides_of(scene, "box"), kBothSides);
  EXPECT_EQ(sides_of(scene, "sheet"), kBothSides);
}

TEST_F(ImportSides, ASolidWithTJunctionsIsClosed) {
  // A box whose top is two rectangles: the sides' edges have corners of the top inside.
  ObjText text;
  text.object("box");
  const Vec3 lo{0, 0, 0}, hi{2, 1, 1};
  text.face({{0, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 0, 0}});
  text.face({{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1}});
  text.face({{0, 1, 0}, {0, 1, 1}, {2, 1, 1}, {2, 1, 0}});
  text.face({{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}});
  text.face({{2, 0, 0}, {2, 1, 0}, {2, 1, 1}, {2, 0, 1}});
  text.material("grey").floor(0, 0, 0.7, 1, 1).material("lamp").floor(0.7, 0, 2, 1, 1);
  EXPECT_EQ(sides_of(with_materials(text), "box"), kFront);
}

TEST_F(ImportSides, ABoxWithoutItsLidIsOpen) {
  ObjText text;
  text.object("box");
  text.face({{0, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 0, 0}});
  text.face({{0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1}});
  text.face({{0, 1, 0}, {0, 1, 1}, {2, 1, 1}, {2, 1, 0}});
  text.face({{0, 0, 0}, {0, 0, 1}, {0, 1, 1}, {0, 1, 0}});
  text.face({{2, 0, 0}, {2, 1, 0}, {2, 1, 1}, {2, 0, 1}});
  EXPECT_EQ(sides_of(with_materials(text), "box"), kBothSides);
}

TEST_F(ImportSides, ARoomShowsItsInside) {
  const Scene scene = with_materials(ObjText()
                                         .object("room")
                                         .box({0, 0, 0}, {4, 4, 3}, false)
                                         .object("table")
                                         .box({1, 1, 0.5}, {2, 2, 1}));
  EXPECT_EQ(sides_of(scene, "room"), kFront);
  EXPECT_EQ(sides_of(scene, "table"), kFront);
}

TEST_F(ImportSides, ARoomModelledWallByWallShowsItsInside) {
  ObjText text;
  const Vec3 hi{4, 5, 3};
  text.object("floor").floor(0, 0, hi.x, hi.y);
  text.object("ceiling").floor(0, 0, hi.x, hi.y, hi.z, false);
  text.object("south").face({{0, 0, 0}, {0, 0, 3}, {4, 0, 3}, {4, 0, 0}});
  text.object("north").face({{0, 5, 0}, {4, 5, 0}, {4, 5, 3}, {0, 5, 3}});
  text.object("west").face({{0, 0, 0}, {0, 5, 0}, {0, 5, 3}, {0, 0, 3}});
  text.object("east").face({{4, 0, 0}, {4, 0, 3}, {4, 5, 3}, {4, 5, 0}});
  const Scene scene = with_materials(text);
  EXPECT_NE(warning(scene, "together close a shell"), nullptr);
  for (const char* wall : {"floor", "ceiling", "south", "north", "west", "east"})
    EXPECT_EQ(sides_of(scene, wall), kFront) << wall;
}

TEST_F(ImportSides, ASolidInsideOutGetsBoth) {
  const Scene scene = with_materials(ObjText()
                                         .object("table")
                                         .box({1, 1, 0.5}, {2, 2, 1}, false)
                                         .object("floor")
                                         .floor(0, 0, 4, 4));
  EXPECT_EQ(sides_of(scene, "table"), kBothSides);
  EXPECT_NE(warning(scene, "inside out"), nullptr);
}

TEST_F(ImportSides, ABoxRoomFacingOutwardsRoundALampGetsBoth) {
  const Scene scene = with_materials(ObjText()
                                         .object("room")
                                         .material("grey")
                                         .box({0, 0, 0}, {4, 4, 3})
                                         .object("lamp")
                                         .material("lamp")
                                         .floor(1, 1, 2, 2, 2.5, false));
  EXPECT_EQ(sides_of(scene, "room"), kBothSides);
}

TEST_F(ImportSides, ALampInTheHollowOfASolidShellIsNotWithinIt) {
  // A building of thick walls: its outer shell faces out, its hollow faces in, a lamp hangs inside.
  const Scene scene = with_materials(ObjText()
                                         .object("walls")
                                         .material("grey")
                                         .box({0, 0, 0}, {4, 4, 3})
                                         .box({0.2, 0.2, 0.2}, {3.8, 3.8, 2.8}, false)
                                         .object("lamp")
                                         .material("lamp")
                                         .floor(1, 1, 2, 2, 2.5, false));
  EXPECT_EQ(sides_of(scene, "walls"), kFront);
}

TEST_F(ImportSides, SolidsOfOneObjectThatTouchAreStillSolids) {
  const Scene scene = with_materials(
      ObjText().object("bricks").box({0, 0, 0}, {1, 1, 1}).box({1, 0, 0}, {2, 1, 1}));
  EXPECT_EQ(sides_of(scene, "bricks"), kFront);
}

}  // namespace
}  // namespace atrium
