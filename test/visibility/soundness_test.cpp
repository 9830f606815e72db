// The judge is judged: sound models pass, and what is taken away or planted is found out.
#include "visibility/soundness.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "test/visibility/models.h"
#include "test/visibility/scene_builder.h"
#include "visibility/second_look.h"
#include "visibility/tube_soundness.h"

namespace atrium {
namespace {

// Rows where keep(receiver, source) says so; all pairs stand to choice.
template <class Keep>
void set_rows(Model& model, Keep&& keep) {
  Rows<ClusterId> rows;
  for (std::uint32_t i = 0; i < model.clusters.size(); ++i) {
    std::vector<ClusterId> row;
    for (std::uint32_t j = 0; j < model.clusters.size(); ++j)
      if (keep(ClusterId(i), ClusterId(j))) row.push_back(ClusterId(j));
    rows.push_row(row);
  }
  model.visible = std::move(rows);
}

// Takes the pair out of both rows.
void hide(Model& model, ClusterId a, ClusterId b) {
  const Model before = model;
  set_rows(model, [&](ClusterId i, ClusterId j) {
    return listed(before, i, j) && std::minmax({i, j}) != std::minmax({a, b});
  });
}

SceneBuilder room_with_table() {
  SceneBuilder s;
  s.quad("floor", {0, 0, 0}, {5, 0, 0}, {0, 4, 0});
  s.quad("ceiling", {0, 0, 3}, {0, 4, 0}, {5, 0, 0});
  s.quad("walls", {0, 0, 0}, {0, 4, 0}, {0, 0, 3});
  s.quad("walls", {5, 0, 0}, {0, 0, 3}, {0, 4, 0});
  s.quad("walls", {0, 0, 0}, {0, 0, 3}, {5, 0, 0});
  s.quad("walls", {0, 4, 0}, {5, 0, 0}, {0, 0, 3});
  s.box("table", {1, 1, 0.7}, {4, 3, 0.75});
  s.lamp("lamp", {2.5, 2, 2.9}, 0.6);
  return s;
}

constexpr SoundnessOptions kShort{100'000, 1, 5'000};

TEST(Soundness, ASoundModelPasses) {
  const Scene scene = room_with_table().build();
  const SoundnessReport r = judge_visibility(scene, made(scene), kShort);
  EXPECT_EQ(r.violations(), 0u) << (r.examples.empty() ? "" : r.examples.front());
  EXPECT_GT(r.joined, 10'000u);
  EXPECT_GT(r.blocked, 10'000u);
  EXPECT_GT(r.tubes.invisible, 100u);
  EXPECT_GT(r.tubes.visible, 100u);
  EXPECT_GT(r.tubes.partial, 100u);
}

TEST(Soundness, APairThatRowsLackIsFoundOutAndNamed) {
  const Scene scene = room_with_table().build();
  Model model = made(scene);
  hide(model, cluster_of(model, scene, "lamp"), cluster_of(model, scene, "floor"));
  const SoundnessReport r = judge_visibility(scene, model, kShort);
  EXPECT_GT(r.missed_sources, 0u);
  ASSERT_FALSE(r.examples.empty());
  EXPECT_NE(r.examples.front().find("'lamp'"), std::string::npos) << r.examples.front();
  EXPECT_NE(r.examples.front().find("'floor'"), std::string::npos) << r.examples.front();
}

TEST(Soundness, APairThatOneRowAloneLacksIsFoundOut) {
  const Scene scene = room_with_table().build();
  Model model = made(scene);
  const ClusterId lamp = cluster_of(model, scene, "lamp"),
                  walls = cluster_of(model, scene, "walls");
  for (const auto& [lacking, other] : {std::pair{lamp, walls}, std::pair{walls, lamp}}) {
    const Model before = made(scene);
    set_rows(model, [&](ClusterId i, ClusterId j) {
      return listed(before, i, j) && !(i == lacking && j == other);
    });
    EXPECT_GT(judge_visibility(scene, model, kShort).missed_sources, 0u);
  }
}

TEST(Soundness, ABlockerThatARowLacksIsFoundOut) {
  const Scene scene = room_with_table().build();
  Model model = made(scene);
  // A table that is black all over sends nothing: it is in rows as a blocker alone.
  const ClusterId table = cluster_of(model, scene, "table");
  for (Patch& p : model.patches) p.inert |= p.cluster == table;
  EXPECT_EQ(judge_visibility(scene, model, kShort).violations(), 0u);
  hide(model, table, cluster_of(model, scene, "floor"));
  const SoundnessReport r = judge_visibility(scene, model, kShort);
  EXPECT_EQ(r.missed_sources, 0u);
  EXPECT_GT(r.missed_blockers, 0u);
  ASSERT_FALSE(r.examples.empty());
  EXPECT_NE(r.examples.front().find("first meets 'table'"), std::string::npos)
      << r.examples.front();
}

TEST(Soundness, ClosedRoomsNeverJoinAndTheRatioIsAsCounted) {
  SceneBuilder s;
  s.box("first room", {0, 0, 0}, {4, 4, 3}, true);
  s.lamp("first lamp", {2, 2, 2.9}, 0.6);
  s.box("second room", {4.2, 0, 0}, {8.2, 4, 3}, true);
  s.lamp("second lamp", {6.2, 2, 2.9}, 0.6);
  const Scene scene = s.build();
  Model model = made(scene);
  ASSERT_EQ(model.clusters.size(), 4u);
  set_rows(model, [](ClusterId, ClusterId) { return true; });
  const SoundnessReport r = judge_visibility(scene, model, kShort);
  EXPECT_EQ(r.violations(), 0u);
  // Four clusters have six pairs and four with themselves. A lamp sees its room and not itself, a
  // room sees itself and its lamp.
  EXPECT_EQ(r.others.kept, 6u);
  EXPECT_EQ(r.others.witnessed, 2u);
  EXPECT_EQ(r.selves.kept, 4u);
  EXPECT_EQ(r.selves.witnessed, 2u);
  EXPECT_DOUBLE_EQ(r.pairs().ratio(), 10.0 / 4.0);
  EXPECT_DOUBLE_EQ(r.mean_share, 1);
  EXPECT_DOUBLE_EQ(r.largest_share, 1);
}

// Light creeps in under a rug from the strip of floor that it leaves bare.
TEST(Soundness, EndsUnderACoverThatRaysPassAccuseNobody) {
  SceneBuilder s;
  s.quad("ceiling", {0, 0, 3}, {0, 4, 0}, {5, 0, 0});
  s.lamp("lamp", {2.5, 2, 2.9}, 0.6);
  s.quad("strip", {4.5, 0, 0}, {0.5, 0, 0}, {0, 4, 0});
  s.quad("floor", {0, 0, 0}, {4.5, 0, 0}, {0, 4, 0});
  const double height = 0.3 * kNearOfDiagonal * s.build().bounds.diagonal();
  s.quad("rug", {0, 0, height}, {4.5, 0, 0}, {0, 4, 0}, kBothSides);
  const Scene scene = s.build();
  ASSERT_GT(height, SecondLook(scene).width());
  Model model = made(scene);
  const ClusterId floor = cluster_of(model, scene, "floor"), rug = cluster_of(model, scene, "rug");
  const Model before = model;
  set_rows(model, [&](ClusterId i, ClusterId j) {
    if (i != floor && j != floor) return listed(before, i, j);
    return std::minmax({i, j}) == std::minmax({floor, rug});
  });
  const SoundnessReport covered = judge_visibility(scene, model, kShort);
  EXPECT_EQ(covered.missed_sources + covered.missed_blockers, 0u) << covered.examples.front();
  // With the rug out of the way the same floor sees the room.
  Scene uncovered = scene;
  for (std::size_t i = 1; i <= 4; ++i) uncovered.vertices[uncovered.vertices.size() - i].z += 10;
  EXPECT_GT(judge_visibility(uncovered, model, kShort).missed_sources, 0u);
}

TEST(Soundness, TheSameForAnyNumberOfThreads) {
  const Scene scene = two_rooms_with_doorway().build();
  Model model = made(scene);
  hide(model, cluster_of(model, scene, "lamp"), cluster_of(model, scene, "floor"));
  const auto judged = [&](int threads) {
    SoundnessReport r;
    tbb::task_arena(threads).execute([&] { r = judge_visibility(scene, model, kShort); });
    return r;
  };
  const SoundnessReport one = judged(1), two = judged(2);
  EXPECT_GT(one.missed_sources, 0u);
  EXPECT_EQ(one.joined, two.joined);
  EXPECT_EQ(one.blocked, two.blocked);
  EXPECT_EQ(one.missed_sources, two.missed_sources);
  EXPECT_EQ(one.missed_blockers, two.missed_blockers);
  EXPECT_EQ(one.pairs().witnessed, two.pairs().witnessed);
  EXPECT_EQ(one.tubes.visible, two.tubes.visible);
  EXPECT_EQ(one.tubes.invisible, two.tubes.invisible);
  EXPECT_EQ(one.examples, two.examples);
}

// Tubes drawn among `believed`, rays among the scene's own surfaces.
TubeCounts judge_tubes(const Scene& scene, const Scene& believed) {
  const Model model = made(scene);
  std::vector<BlockerPolygon> real, told;
  for (const Surface& s : scene.surfaces)
    real.push_back({scene.polygon(s), static_cast<std::uint32_t>(real.size())});
  for (const Surface& s : believed.surfaces)
    told.push_back({believed.polygon(s), static_cast<std::uint32_t>(told.size())});
  const PatchSampler sampler(model);
  const SecondLook look(scene);
  const RayScene rays(real);
  const TubeJudge judge(scene, model, sampler, look, told, rays);
  RandomStream random(1, 0);
  TubeTally tally;
  for (int i = 0; i < 2'000; ++i) judge.judge(random, tally);
  return tally.counts;
}

TEST(Soundness, TubesThatMissABlockerOrImagineOneAreFoundOut) {
  const SceneBuilder empty = room_with_table();
  SceneBuilder parted = empty;
  parted.quad("plate", {0, 0, 1.5}, {5, 0, 0}, {0, 4, 0}, kBothSides);
  parted.lamp("lower lamp", {2.5, 2, 1.4}, 0.6);
  const Scene scene = parted.build();
  const TubeCounts right = judge_tubes(scene, scene);
  EXPECT_EQ(right.wrongly_visible + right.wrongly_invisible, 0u);
  // The plate parts the room; tubes that do not know the table see through it.
  Scene without = scene;
  std::erase_if(without.surfaces, [&](const Surface& s) { return name_of(scene, s) == "table"; });
  EXPECT_GT(judge_tubes(scene, without).wrongly_visible, 0u);
  EXPECT_GT(judge_tubes(empty.build(), scene).wrongly_invisible, 0u);
}

// A wall across the way with a slit in it, at x = 1, from side to side.
Scene slit(double width) {
  SceneBuilder s;
  s.quad("wall", {1, -1, -1}, {0, 2, 0}, {0, 0, 1 - 0.5 * width});
  s.quad("wall", {1, -1, 0.5 * width}, {0, 2, 0}, {0, 0, 1 - 0.5 * width});
  s.quad("start", {0, -1, -1}, {0, 2, 0}, {0, 0, 2});
  s.quad("end", {2, -1, -1}, {0, 0, 2}, {0, 2, 0});
  return s.build();
}

TEST(SecondLook, ASlitIsFreeWhereItIsWiderThanTheWorkOfTolerances) {
  const FacePoint x{{0, 0, 0}, {{1, 0, 0}, 0}}, y{{2, 0, 0}, {{-1, 0, 0}, -2}};
  const double width = SecondLook(slit(0.1)).width();
  EXPECT_TRUE(SecondLook(slit(0.1)).surely_free(x, y));
  EXPECT_TRUE(SecondLook(slit(2.2 * width)).surely_free(x, y));
  EXPECT_FALSE(SecondLook(slit(1.8 * width)).surely_free(x, y));
}

TEST(SecondLook, ACrossingIsSureWellWithinTheEdgesAndAwayFromThePlane) {
  const Scene scene = slit(0.1);
  const SecondLook look(scene);
  const auto through = [&](double z) {
    return look.sure_crossing({0, 0, z}, {2, 0, z}, SurfaceId(1u));
  };
  const auto hit = through(0.5);
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(length(hit->at - Vec3{1, 0, 0.5}), 0, 1e-12);
  EXPECT_LT(hit->plane.normal.x, 0);  // it faces where the segment comes from
  EXPECT_TRUE(through(0.05 + 2 * look.width()).has_value());
  EXPECT_FALSE(through(0.05 + 0.5 * look.width()).has_value());
  EXPECT_FALSE(through(0).has_value());
  const double close = 0.5 * look.width();
  EXPECT_FALSE(look.sure_crossing({1 - close, -1, 0.5}, {2, 1, 0.5}, SurfaceId(1u)).has_value());
}

TEST(SecondLook, FacesInFrontCrowdAnEndAndThoseAtOrBehindItsPlaneDoNot) {
  SceneBuilder s;
  s.quad("floor", {0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  s.quad("slab below shares the face", {0, 0, 0}, {0, 1, 0}, {1, 0, 0});
  s.quad("wall", {0.5, 0, 0}, {0, 1, 0}, {0, 0, 1});
  s.quad("rug", {0.8, 0, 5e-6}, {0.2, 0, 0}, {0, 1, 0});
  const Scene scene = s.build();
  const SecondLook look(scene);
  ASSERT_GT(look.near(), 5e-6);
  const Plane up{{0, 0, 1}, 0};
  EXPECT_FALSE(look.crowded({{0.2, 0.5, 0}, up}));
  EXPECT_TRUE(look.crowded({{0.5, 0.5, 0}, up}));  // at the wall's foot
  EXPECT_TRUE(look.crowded({{0.9, 0.5, 0}, up}));  // under the rug
  EXPECT_FALSE(look.crowded({{0.9, 0.5, 0}, up.flipped()}));
}

}  // namespace
}  // namespace atrium
