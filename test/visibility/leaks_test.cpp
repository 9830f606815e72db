// Leaks planted in models of two rooms, and models that have none.
//
// The rooms are the inside of an outer box of 8.2 × 4 × 3 m (walls 0.2 m thick, so an outer face
// beyond), parted by a wall of 0.2 m from x = 4 to 4.2. All solids are closed boxes, with an inside
// of their own, as modellers leave them.
#include <gtest/gtest.h>

#include <set>

#include "test/visibility/scene_builder.h"
#include "visibility/leaks.h"

namespace atrium {
namespace {

constexpr double kX0 = 4, kX1 = 4.2, kEnd = 8.2, kDepth = 4, kHeight = 3, kThick = 0.2;
constexpr double kGap = 0.01;          // m, planted
constexpr double kSize = 0.05;         // m, the largest that is a leak
constexpr double kWidthError = 2e-3;   // relative: what the search for a width stops at, twice
constexpr double kLengthError = 0.02;  // relative

// `foot`: the gap under the north wall.
SceneBuilder shell(double foot = 0) {
  return shell_of_slabs({kEnd, kDepth, kHeight}, kThick, foot);
}

SceneBuilder& wall(SceneBuilder& s, const std::string& name, double y0, double y1, double z0,
                   double z1) {
  return s.box(name, {kX0, y0, z0}, {kX1, y1, z1});
}

std::vector<Leak> leaks_of(const Scene& scene) {
  return find_leaks(scene, find_room_plan(scene), kSize);
}

Vec3 moved(const Vec3& x) { return turned(x, 17) + Vec3{100, -50, 7}; }

std::set<std::string> names(const Scene& scene, const Leak& leak) {
  std::set<std::string> out;
  for (ObjectId o : leak.objects) out.insert(scene.objects[o.value].name);
  return out;
}

// One leak of the width and length, in place and in a moved copy, named by these objects at least.
void expect_one(const SceneBuilder& builder, double width, double length, const Vec3& at,
                const std::set<std::string>& objects, bool outdoors = false) {
  for (const bool move : {false, true}) {
    const Scene scene = move ? builder.build(moved) : builder.build();
    const std::vector<Leak> leaks = leaks_of(scene);
    ASSERT_EQ(leaks.size(), 1u) << "moved: " << move;
    const Leak& leak = leaks.front();
    EXPECT_NEAR(leak.width, width, kWidthError * width);
    EXPECT_NEAR(leak.length, length, kLengthError * length);
    EXPECT_LT(glm::length(leak.at - (move ? moved(at) : at)), 0.5 * length + 0.2);
    EXPECT_NE(leak.spaces[0], leak.spaces[1]);
    EXPECT_EQ(leak.spaces[1] == kOutdoors, outdoors);
    const std::set<std::string> found = names(scene, leak);
    for (const std::string& name : objects) EXPECT_TRUE(found.contains(name)) << name;
  }
}

void expect_none(const SceneBuilder& builder) {
  EXPECT_TRUE(leaks_of(builder.build()).empty());
  EXPECT_TRUE(leaks_of(builder.build(moved)).empty());
}

TEST(Leaks, RoomPlanOfTwoRoomsHasTwo) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, 0, kHeight);
  for (const auto& scene : {s.build(), s.build(moved)}) EXPECT_EQ(find_room_plan(scene).rooms, 2u);
}

TEST(Leaks, RoomPlanOfTwoRoomsWithDoorwayHasTwo) {
  const SceneBuilder s = two_rooms_with_doorway();
  EXPECT_EQ(find_room_plan(s.build()).rooms, 2u);
}

TEST(Leaks, NoneWhereWallsMeet) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, 0, kHeight);
  expect_none(s);
}

TEST(Leaks, NoneInRoomsWithDoorway) { expect_none(two_rooms_with_doorway()); }

TEST(Leaks, UprightCrackBetweenTwoPartsOfWall) {
  SceneBuilder s = shell();
  wall(s, "wall a", 0, 2, 0, kHeight);
  wall(s, "wall b", 2 + kGap, kDepth, 0, kHeight);
  expect_one(s, kGap, kHeight, {4.1, 2, 1.5}, {"wall a", "wall b"});
}

TEST(Leaks, CrackBesideDoorway) {
  SceneBuilder s = shell();
  wall(s, "wall a", 0, 1.5, 0, kHeight);
  wall(s, "wall b", 1.5 + kGap, 2.5, 0, kHeight);
  wall(s, "wall c", 3.3, kDepth, 0, kHeight);
  wall(s, "lintel", 2.5, 3.3, 2, kHeight);
  expect_one(s, kGap, kHeight, {4.1, 1.5, 1.5}, {"wall a", "wall b"});
}

TEST(Leaks, CrackAtWallsFoot) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, kGap, kHeight);
  expect_one(s, kGap, kDepth, {4.1, 2, 0}, {"wall", "floor"});
}

TEST(Leaks, CrackAtWallsHead) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, 0, kHeight - kGap);
  expect_one(s, kGap, kDepth, {4.1, 2, kHeight}, {"wall", "ceiling"});
}

TEST(Leaks, CrackWhereWallMissesAnother) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth - kGap, 0, kHeight);
  expect_one(s, kGap, kHeight, {4.1, kDepth, 1.5}, {"wall", "north"});
}

TEST(Leaks, CrackAtOuterWallsFootLeadsOutdoorsFromBothRooms) {
  SceneBuilder s = shell(kGap);
  wall(s, "wall", 0, kDepth, 0, kHeight);
  for (const auto& scene : {s.build(), s.build(moved)}) {
    const std::vector<Leak> leaks = leaks_of(scene);
    ASSERT_EQ(leaks.size(), 2u);
    EXPECT_NE(leaks[0].spaces[0], leaks[1].spaces[0]);
    for (const Leak& leak : leaks) {
      EXPECT_EQ(leak.spaces[1], kOutdoors);
      EXPECT_NEAR(leak.width, kGap, kWidthError * kGap);
      EXPECT_TRUE(names(scene, leak).contains("north"));
    }
  }
}

// The north wall ends short of the corner where the west wall's edge is: a slit past both.
TEST(Leaks, CrackWhereWallsMeetAtEdgesOnly) {
  SceneBuilder s;
  s.box("floor", {-0.2, -0.2, -0.2}, {4.2, 4.2, 0});
  s.box("ceiling", {-0.2, -0.2, kHeight}, {4.2, 4.2, kHeight + 0.2});
  s.box("west", {-0.2, -0.2, 0}, {0, 4, kHeight});
  s.box("east", {4, -0.2, 0}, {4.2, 4.2, kHeight});
  s.box("south", {0, -0.2, 0}, {4, 0, kHeight});
  s.box("north", {kGap, 4, 0}, {4, 4.2, kHeight});
  expect_one(s, kGap, kHeight, {0, 4, 1.5}, {"west", "north"}, true);
}

TEST(Leaks, KeyholeThroughWall) {
  SceneBuilder s = shell();
  const double y = 2, z = 1;
  wall(s, "wall a", 0, y, 0, kHeight);
  wall(s, "wall b", y + kGap, kDepth, 0, kHeight);
  wall(s, "under", y, y + kGap, 0, z);
  wall(s, "over", y, y + kGap, z + kGap, kHeight);
  expect_one(s, kGap, kGap, {4.1, y, z}, {"wall a", "wall b", "under", "over"});
}

TEST(Leaks, TwoCracksInOneWallAreTwo) {
  SceneBuilder s = shell();
  wall(s, "wall a", 0, 1, 0, kHeight);
  wall(s, "wall b", 1 + kGap, 3, 0, kHeight);
  wall(s, "wall c", 3 + 2 * kGap, kDepth, 0, kHeight);
  const std::vector<Leak> leaks = leaks_of(s.build());
  ASSERT_EQ(leaks.size(), 2u);
  EXPECT_NEAR(leaks[0].width, 2 * kGap, kWidthError * 2 * kGap);  // the widest first
  EXPECT_NEAR(leaks[1].width, kGap, kWidthError * kGap);
}

TEST(Leaks, WindowOf80cmIsNone) {
  SceneBuilder s = shell();
  const double y = 2, z = 1, w = 0.8;
  wall(s, "wall a", 0, y, 0, kHeight);
  wall(s, "wall b", y + w, kDepth, 0, kHeight);
  wall(s, "under", y, y + w, 0, z);
  wall(s, "over", y, y + w, z + w, kHeight);
  EXPECT_EQ(find_room_plan(s.build()).rooms, 2u);
  expect_none(s);
}

TEST(Leaks, AirGapBehindCupboardIsNone) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, 0, kHeight);
  s.box("cupboard", {kX0 - kGap - 0.6, 1, 0}, {kX0 - kGap, 3, 2});
  expect_none(s);
}

TEST(Leaks, CrackInThinWall) {
  SceneBuilder s = shell();
  s.quad("wall a", {kX0, 0, 0}, {0, 2, 0}, {0, 0, kHeight}, kBothSides);
  s.quad("wall b", {kX0, 2 + kGap, 0}, {0, kDepth - 2 - kGap, 0}, {0, 0, kHeight}, kBothSides);
  expect_one(s, kGap, kHeight, {kX0, 2, 1.5}, {"wall a", "wall b"});
}

TEST(Leaks, OpeningsAboveTheSizeAreNone) {
  SceneBuilder s = shell();
  wall(s, "wall", 0, kDepth, 2 * kGap, kHeight);
  const Scene scene = s.build();
  const RoomPlan plan = find_room_plan(scene);
  EXPECT_EQ(find_leaks(scene, plan, 3 * kGap).size(), 1u);
  EXPECT_EQ(find_leaks(scene, plan, kGap).size(), 0u);
}

}  // namespace
}  // namespace atrium
