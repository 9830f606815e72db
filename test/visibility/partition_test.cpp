#include "visibility/partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "test/visibility/models.h"
#include "test/visibility/scene_builder.h"
#include "visibility/soundness.h"

namespace atrium {
namespace {

void expect_sound(const Scene& scene, const Model& model) {
  const SoundnessReport report = judge_visibility(scene, model, {.segments = 200'000});
  EXPECT_GT(report.joined, 10'000u);
  EXPECT_GT(report.blocked, 10'000u);
  EXPECT_EQ(report.violations(), 0u) << report.examples.front();
}

double lit_area(const Model& model, const Scene& scene, const std::string& object) {
  double sum = 0;
  for (const Patch& p : model.patches)
    if (!p.inert && name_of(scene, scene.surfaces[p.surface.value]) == object)
      sum += area(model.polygon(p));
  return sum;
}

std::size_t patches_of(const Model& model, const Scene& scene, const std::string& object) {
  std::size_t n = 0;
  for (const Patch& p : model.patches)
    n += name_of(scene, scene.surfaces[p.surface.value]) == object;
  return n;
}

SceneBuilder room_with_lamp() {
  SceneBuilder s;
  s.box("room", {0, 0, 0}, {5, 4, 3}, true);
  s.lamp("lamp", {2.5, 2, 2.9}, 0.6);
  return s;
}

TEST(Partition, ASceneWithoutAnyLightIsRefused) {
  SceneBuilder s;
  s.box("room", {0, 0, 0}, {5, 4, 3}, true);
  const Result<Model> model = partition(s.build());
  ASSERT_FALSE(model.ok());
  EXPECT_EQ(model.status().code(), Code::kScene);
}

TEST(Partition, AClosedRoomIsLitInsideOnlyAndUncut) {
  const Scene scene = room_with_lamp().build();
  const Model model = made(scene);
  EXPECT_EQ(patches_of(model, scene, "room"), 6u);
  // The lamp and its black back.
  EXPECT_EQ(patches_of(model, scene, "lamp"), 2u);
  EXPECT_NEAR(lit_area(model, scene, "room"), 2 * (5 * 4 + 4 * 3 + 3 * 5), 1e-9);
  EXPECT_EQ(model.clusters.size(), 2u);
  EXPECT_EQ(model.rooms, 1u);
  EXPECT_EQ(model.dark_surfaces, 0u);
  // The room sees itself and the lamp; the lamp, all in one plane, sees the room alone.
  ASSERT_EQ(model.visible[0].size(), 2u);
  ASSERT_EQ(model.visible[1].size(), 1u);
  EXPECT_EQ(model.visible[1][0], ClusterId(0u));
}

TEST(Partition, InsideAClosedBoxItIsDark) {
  SceneBuilder s = room_with_lamp();
  s.box("box", {1, 1, 0.5}, {2, 2, 1.5});
  s.quad("hidden", {1.2, 1.2, 1}, {0.5, 0, 0}, {0, 0.5, 0}, kBothSides);
  const Scene scene = s.build();
  const Model model = made(scene);
  EXPECT_EQ(model.dark_surfaces, 1u);
  EXPECT_EQ(patches_of(model, scene, "hidden"), 0u);
  EXPECT_EQ(patches_of(model, scene, "box"), 6u);
  EXPECT_EQ(patches_of(model, scene, "room"), 6u);
}

TEST(Partition, AFloorIsDarkUnderACrateThatPartsSpaceAndLosesNothingElse) {
  SceneBuilder s = room_with_lamp();
  s.box("crate", {1, 1, 0}, {2, 2, 1});
  const Scene scene = s.build();
  const Model model = made(scene);
  const double shell = 2 * (5 * 4 + 4 * 3 + 3 * 5);
  EXPECT_NEAR(lit_area(model, scene, "room"), shell - 1, 1e-4);
  EXPECT_NEAR(lit_area(model, scene, "crate"), 5, 1e-9);
  EXPECT_LE(patches_of(model, scene, "room"), 5u + 4u);
}

// Four sheets about a parallelogram, of which both sides count; turned, so that they part no space.
void add_sides(SceneBuilder& s, const std::string& object, const Vec3& a, const Vec3& u,
               const Vec3& v, const Vec3& up) {
  s.quad(object, a, u, up, kBothSides).quad(object, a + u, v, up, kBothSides);
  s.quad(object, a + u + v, -u, up, kBothSides).quad(object, a + v, -v, up, kBothSides);
}

// A crate of four sides, open above so that it parts no space: what of the floor is inside is a
// patch by itself, and the floor loses nothing.
TEST(Partition, AFloorIsCutAlongTheOutlineOfWhatStandsOnIt) {
  SceneBuilder s = room_with_lamp();
  const Vec3 a{2, 1, 0}, u{0.6, 0.3, 0}, v{-0.3, 0.6, 0}, up{0, 0, 0.5};
  add_sides(s, "crate", a, u, v, up);
  const Scene scene = s.build();
  const Model model = made(scene);
  double inside = 0;
  for (const Patch& p : model.patches)
    if (p.footprint) {
      inside += area(model.polygon(p));
      EXPECT_NEAR(length(centroid(model.polygon(p)) - (a + 0.5 * (u + v))), 0, 1e-9);
    }
  EXPECT_NEAR(inside, length(u) * length(v), 1e-9);
  EXPECT_NEAR(lit_area(model, scene, "room"), 2 * (5 * 4 + 4 * 3 + 3 * 5), 1e-9);
  EXPECT_EQ(patches_of(model, scene, "room"), 5u + 4u + 1u);
}

// A crate without a bottom, turned so that it parts no space; both sides of its sheets count.
// Inside it is dark, for the sheets as for the floor.
SceneBuilder room_with_crate(const Vec3& a, double height = 0.5) {
  SceneBuilder s = room_with_lamp();
  const Vec3 u{0.6, 0.3, 0}, v{-0.3, 0.6, 0}, up{0, 0, height};
  add_sides(s, "crate", a, u, v, up);
  return s.quad("crate", a + up, u, v, kBothSides);
}
constexpr double kFootprint = 0.6 * 0.6 + 0.3 * 0.3;  // m²
constexpr double kRoomShell = 2 * (5 * 4 + 4 * 3 + 3 * 5);

TEST(Partition, InsideAnUpturnedCrateItIsDark) {
  const Scene scene = room_with_crate({2, 1, 0}).build();
  const Model model = made(scene);
  const double side = std::sqrt(kFootprint);
  EXPECT_NEAR(lit_area(model, scene, "crate"), kFootprint + 4 * side * 0.5, 1e-9);
  EXPECT_NEAR(lit_area(model, scene, "room"), kRoomShell - kFootprint, 1e-9);
}

// From floor to ceiling, sealed by either.
TEST(Partition, InsideAPillarItIsDark) {
  SceneBuilder s = room_with_lamp();
  const Vec3 a{1, 1, 0}, u{0.3, 0.1, 0}, v{-0.1, 0.3, 0}, up{0, 0, 3};
  add_sides(s, "pillar", a, u, v, up);
  const Scene scene = s.build();
  const Model model = made(scene);
  EXPECT_NEAR(lit_area(model, scene, "pillar"), 4 * std::sqrt(0.1) * 3, 1e-9);
  EXPECT_NEAR(lit_area(model, scene, "room"), kRoomShell - 2 * 0.1, 1e-9);
}

// Nothing of that where light may come in: a crate a hand above the floor, one that stands over a
// step, one with a lamp in it.
TEST(Partition, ACrateThatIsNotSealedIsLitInside) {
  const double inside = 2 * (kFootprint + 4 * std::sqrt(kFootprint) * 0.5);
  const Scene lifted = room_with_crate({2, 1, 0.1}).build();
  EXPECT_NEAR(lit_area(made(lifted), lifted, "crate"), inside, 1e-9);
  SceneBuilder step = room_with_crate({2, 1, 0.1});
  step.box("step", {1.9, 0.9, 0}, {2.3, 2, 0.1});
  const Scene across = step.build();
  EXPECT_NEAR(lit_area(made(across), across, "crate"), inside, 1e-9);
  SceneBuilder lantern = room_with_crate({2, 1, 0});
  lantern.lamp("bulb", {2.15, 1.45, 0.3}, 0.1);
  const Scene lit = lantern.build();
  EXPECT_NEAR(lit_area(made(lit), lit, "crate"), inside, 1e-9);
}

// What is far too small for it, the feet of a table, cuts no floor.
TEST(Partition, SmallFeetCutNoFloor) {
  SceneBuilder s = room_with_lamp();
  for (const Vec3& foot : {Vec3{1, 1, 0}, Vec3{2, 1, 0}, Vec3{1, 2, 0}, Vec3{2, 2, 0}})
    s.box("table", foot, foot + Vec3{0.05, 0.05, 0.7});
  EXPECT_EQ(patches_of(made(s.build()), s.build(), "room"), 6u);
}

TEST(Partition, ASlabUnderAWallIsCutThereAndNowhereElse) {
  const Scene scene = two_rooms_with_doorway().build();
  const Model model = made(scene);
  // A piece in each room and one in the doorway.
  EXPECT_EQ(patches_of(model, scene, "floor"), 3u);
  EXPECT_NEAR(lit_area(model, scene, "floor"), 2 * 4 * 4 + 0.2 * 1, 1e-4);
  EXPECT_EQ(patches_of(model, scene, "ceiling"), 2u);
  EXPECT_NEAR(lit_area(model, scene, "ceiling"), 2 * 4 * 4, 1e-4);
  EXPECT_EQ(patches_of(model, scene, "west"), 1u);
  EXPECT_EQ(patches_of(model, scene, "wall"), 6u);
}

TEST(Partition, ASlabUnderAWallWithoutDoorwayIsLitOnTheLampsSideOnly) {
  SceneBuilder s;
  s.box("slab and shell", {0, 0, 0}, {8, 4, 3}, true);
  s.quad("wall", {4, 0, 0}, {0, 4, 0}, {0, 0, 3}, kBothSides);
  s.lamp("lamp", {2, 2, 2.9}, 0.5);
  const Scene scene = s.build();
  const Model model = made(scene);
  EXPECT_NEAR(lit_area(model, scene, "slab and shell"), 2 * (4 * 4 + 4 * 3) + 4 * 3, 1e-4);
  EXPECT_NEAR(lit_area(model, scene, "wall"), 4 * 3, 1e-9);
  EXPECT_EQ(model.dark_surfaces, 1u);  // the shell's far end
  EXPECT_EQ(model.rooms, 1u);
}

// A room with a niche in one wall, whose back covers little of what its plane cuts of the yard
// behind the room, and a crate in the yard.
Scene room_with_niche(bool lamp_in_the_yard) {
  SceneBuilder s;
  s.box("room", {0, 0, 0}, {5, 4, 3}, true);
  const Vec3 y{0, 4, 0}, z{0, 0, 1};
  s.quad("wall below", {0, 0, 0}, y, z);
  s.quad("wall above", {0, 0, 2}, y, z);
  s.quad("wall left", {0, 0, 1}, {0, 1, 0}, z);
  s.quad("wall right", {0, 2, 1}, {0, 2, 0}, z);
  s.box("niche", {-0.1, 1, 1}, {0, 2, 2}, true);
  s.lamp("lamp", {2.5, 2, 2.9}, 0.6);
  s.box("crate in the yard", {-12, -5, -2}, {-11, -4, -1});
  if (lamp_in_the_yard) s.lamp("lamp in the yard", {-10, -2, 5}, 0.6);
  Scene scene = s.build();
  // The room's own wall and the niche's open side go.
  std::erase_if(scene.surfaces, [&](const Surface& surface) {
    const std::string& object = name_of(scene, surface);
    const Box box = bounds(scene.polygon(surface));
    return (object == "room" && box.hi.x < 0.1) || (object == "niche" && box.lo.x > -0.05);
  });
  return scene;
}

TEST(Partition, ANicheInAWallKeepsDarkWhatLiesBehindTheWall) {
  const Scene scene = room_with_niche(false);
  const Model model = made(scene);
  EXPECT_EQ(model.dark_surfaces, 6u);
  EXPECT_EQ(patches_of(model, scene, "crate in the yard"), 0u);
  EXPECT_NEAR(lit_area(model, scene, "niche"), 1 + 4 * 0.1, 1e-9);
}

TEST(Partition, ANicheThatKeepsNothingDarkIsNotSplitOff) {
  const Model dark = made(room_with_niche(false)), lit = made(room_with_niche(true));
  EXPECT_LT(lit.cells.size(), dark.cells.size());
  EXPECT_EQ(lit.dark_surfaces, 0u);
}

TEST(Partition, ACrowdOfCratesDoesNotDivideTheAirOfTheirRoom) {
  // Crates of 0.4 m on a floor, one by one further in: few divide the air, many no more.
  const auto cells_with = [](int crates) {
    SceneBuilder s = room_with_lamp();
    for (int i = 0; i < crates; ++i) {
      const Vec3 at{0.3 + 0.7 * (i % 6), 0.3 + 0.6 * (i / 6), 0};
      s.box("crate " + std::to_string(i), at, at + Vec3{0.4, 0.4, 0.5});
    }
    const Scene scene = s.build();
    const Model model = made(scene);
    EXPECT_EQ(model.rooms, 1u);
    const SoundnessReport report = judge_visibility(scene, model, {.segments = 20000});
    EXPECT_EQ(report.violations(), 0u);
    return std::count_if(model.cells.begin(), model.cells.end(),
                         [](const Cell& c) { return c.lit; });
  };
  const auto few = cells_with(2);
  EXPECT_GT(few, 1);
  EXPECT_LT(cells_with(30), few);
}

TEST(Partition, APlaneThatRunsOnThroughARoomsAirJoinsIt) {
  // A cupboard's sides cut the room's space, not the room.
  SceneBuilder s = room_with_lamp();
  s.box("cupboard", {0, 1, 0}, {0.8, 3, 2});
  const Scene scene = s.build();
  const Model model = made(scene);
  EXPECT_GT(model.cells.size(), 7u);
  EXPECT_EQ(model.rooms, 1u);
}

struct Counts {
  std::size_t cells, portals, patches, clusters, pairs, contacts;
  friend bool operator==(const Counts&, const Counts&) = default;
};

Counts counts(const Model& m) {
  return {m.cells.size(),    m.portals.size(),       m.patches.size(),
          m.clusters.size(), m.visible.items.size(), m.contacts.items.size()};
}

SceneBuilder furnished_rooms() {
  SceneBuilder s = two_rooms_with_doorway();
  s.box("table", {1, 2.5, 0.7}, {2.5, 3.5, 0.75});
  s.box("cupboard", {5, 0, 0}, {6, 0.6, 2});
  s.box("crate", {7, 3, 0}, {7.5, 3.5, 0.5});
  return s;
}

TEST(Partition, TurnedShiftedAndScaledCopiesArePartitionedAlike) {
  const Counts straight = counts(made(furnished_rooms().build()));
  EXPECT_EQ(counts(made(furnished_rooms().build([](const Vec3& x) { return turned(x, 17); }))),
            straight);
  EXPECT_EQ(counts(made(furnished_rooms().build([](const Vec3& x) { return x + Vec3{1e5}; }))),
            straight);
  EXPECT_EQ(counts(made(furnished_rooms().build([](const Vec3& x) { return 1e-6 * x; }))),
            straight);
}

TEST(Partition, WhatASegmentJoinsOrIsBlockedByIsVisible) {
  const SceneBuilder s = furnished_rooms();
  for (double degrees : {0.0, 17.0}) {
    const Scene scene = s.build([&](const Vec3& x) { return turned(x, degrees); });
    const Model model = made(scene);
    expect_sound(scene, model);
  }
}

TEST(Partition, DoorwaysAtOppositeEndsHideWhatNoLineThroughBothReaches) {
  for (double degrees : {0.0, 17.0}) {
    const Scene scene = rooms_in_a_row().build([&](const Vec3& x) { return turned(x, degrees); });
    const Model model = made(scene);
    const ClusterId lamp = cluster_of(model, scene, "lamp");
    const ClusterId third = cluster_of(model, scene, "third room");
    EXPECT_TRUE(listed(model, lamp, cluster_of(model, scene, "second room")));
    EXPECT_FALSE(listed(model, lamp, cluster_of(model, scene, "second room's end")));
    EXPECT_FALSE(listed(model, lamp, third));
    // From (5, 2) through (8, 3) on to (9, 3.33).
    EXPECT_TRUE(listed(model, cluster_of(model, scene, "second room's end"), third));
    expect_sound(scene, model);
  }
}

TEST(Partition, ABoxOnAFloorTouchesItAlongFourSegments) {
  SceneBuilder s = room_with_lamp();
  // Too small to part space, so the floor is not cut around it.
  s.box("box", {1, 1, 0}, {1.04, 1.04, 0.04});
  const Scene scene = s.build();
  const Model model = made(scene);
  ASSERT_EQ(patches_of(model, scene, "room"), 6u);
  std::size_t on_floor = 0;
  double length_on_floor = 0;
  for (std::size_t p = 0; p < model.patches.size(); ++p)
    for (const Contact& c : model.contacts[p])
      if (std::abs(c.a.z) < 1e-9 && std::abs(c.b.z) < 1e-9) {
        ++on_floor;
        length_on_floor += length(c.b - c.a);
      }
  EXPECT_EQ(on_floor, 4u);
  EXPECT_NEAR(length_on_floor, 4 * 0.04, 1e-4);
}

TEST(Partition, AnObjectWithTooManyPatchesIsHalvedByProximity) {
  SceneBuilder s = room_with_lamp();
  for (int i = 0; i < 50; ++i)
    s.quad("leaves", {0.05 + 0.09 * i, 1, 1}, {0.05, 0, 0}, {0, 0.05, 0.05}, kBothSides);
  const Scene scene = s.build();
  PartitionOptions options;
  options.most_patches_of_cluster = 30;
  Result<Model> model = partition(scene, options);
  ASSERT_TRUE(model.ok());
  std::size_t leaves = 0, most = 0;
  for (const Cluster& c : model->clusters)
    if (name_of(scene, c) == "leaves") {
      leaves += c.patch_count;
      most = std::max<std::size_t>(most, c.patch_count);
      EXPECT_LT(c.bounds.extent().x, 4.6 / 3);
    }
  EXPECT_EQ(leaves, 100u);
  EXPECT_LE(most, 30u);
}

}  // namespace
}  // namespace atrium
