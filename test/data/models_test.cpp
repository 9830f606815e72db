// The five models of the paper's Tables 2 and 3, and the bigger ones.
#include <gtest/gtest.h>

#include "test/data/model_checks.h"

namespace atrium {
namespace {

struct PaperModel {
  const char* kind;
  std::uint64_t clusters, patches, lights;  // [THFH94, Tables 2 and 3]
  double covered;  // at most this share of the fronts' area lies under something
};

class PaperModels : public testing::TestWithParam<PaperModel> {};

TEST_P(PaperModels, HaveThePrintedCountsAndAreSound) {
  const PaperModel& paper = GetParam();
  for (std::uint64_t seed : {1, 7}) {
    GenerateOptions o;
    o.kind = paper.kind;
    o.seed = seed;
    const GeneratedModel m = generated(o);
    EXPECT_EQ(m.counts().clusters, paper.clusters);
    EXPECT_EQ(m.counts().patches, paper.patches);
    EXPECT_EQ(m.counts().lights, paper.lights);
    expect_sound_faces(m);
    expect_nothing_rejoinable(m);
    expect_no_overlap(m);
    expect_modellers_order(m);
    expect_closed(m, 2000, paper.covered);
  }
}

INSTANTIATE_TEST_SUITE_P(Tables2And3, PaperModels,
                         testing::Values(PaperModel{"office", 36, 127, 18, .005},
                                         PaperModel{"office-low", 70, 1418, 21, .05},
                                         PaperModel{"office-high", 70, 3466, 21, .05},
                                         PaperModel{"floor", 1761, 7054, 788, .01},
                                         PaperModel{"building", 9625, 39979, 7826, .01}),
                         [](const auto& test) {
                           std::string name = test.param.kind;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

bool same(const GeneratedModel& a, const GeneratedModel& b) {
  return a.vertices == b.vertices &&
         std::ranges::equal(a.groups, b.groups, {}, &GeneratedGroup::name, &GeneratedGroup::name);
}

TEST(PaperModels, SameSeedSameModelAndOtherSeedOtherModel) {
  for (const char* kind : {"office-low", "floor"}) {
    GenerateOptions one{.kind = kind}, two{.kind = kind, .seed = 2};
    EXPECT_TRUE(same(generated(one), generated(one))) << kind;
    EXPECT_FALSE(same(generated(one), generated(two))) << kind;
  }
}

TEST(PaperModels, OfficeIsTheSameRoomWhateverItsFurniture) {
  const GeneratedModel bare = generated({.kind = "office"});
  for (const char* kind : {"office-low", "office-high"}) {
    const GeneratedModel m = generated({.kind = kind});
    ASSERT_GT(m.vertices.size(), bare.vertices.size());
    EXPECT_TRUE(
        std::ranges::equal(bare.vertices, std::span(m.vertices).first(bare.vertices.size())));
  }
}

TEST(PaperModels, CoarseAndFineOfficesHoldTheSamePieces) {
  const GeneratedModel low = generated({.kind = "office-low"});
  const GeneratedModel high = generated({.kind = "office-high"});
  EXPECT_TRUE(std::ranges::equal(low.groups, high.groups, {}, &GeneratedGroup::name,
                                 &GeneratedGroup::name));
}

// Lumens a square metre of floor, of which a good half reaches the working plane: 300 to 800 lx.
TEST(PaperModels, LampsGiveRealisticLight) {
  for (const char* kind : {"office", "floor", "building"}) {
    const GeneratedModel m = generated({.kind = kind});
    double lumens = 0, floor = 0;
    for (const GeneratedFace& f : m.faces)
      lumens += area(m.polygon(f)) * std::numbers::pi * luminance(m.paints[f.paint].luminance);
    for (const GeneratedGroup& g : m.groups)
      if (g.name.ends_with("/floor")) floor += area(m.polygon(m.faces[g.first_face]));
    EXPECT_GT(lumens / floor, 500) << kind;
    EXPECT_LT(lumens / floor, 1300) << kind;
  }
}

TEST(Furnished, FloorHoldsTheSamePiecesInEitherGradeAndIsSound) {
  const GeneratedModel low = generated({.kind = "floor", .furnish = "low", .rooms = 30});
  const GeneratedModel high = generated({.kind = "floor", .furnish = "high", .rooms = 30});
  EXPECT_TRUE(std::ranges::equal(low.groups, high.groups, {}, &GeneratedGroup::name,
                                 &GeneratedGroup::name));
  const GeneratedModel bare = generated({.kind = "floor", .rooms = 30});
  EXPECT_GT(low.groups.size(), bare.groups.size() + 300);  // nine pieces a desk, two dozen desks
  expect_sound_faces(high);
  expect_nothing_rejoinable(high);
  expect_no_overlap(high);
  expect_modellers_order(high);
  expect_closed(high, 5000, .06);
}

TEST(Bigger, MoreRoomsAndStoreysGrowTheModelInProportion) {
  const GeneratedModel m = generated({.kind = "building", .storeys = 3, .rooms = 150});
  expect_sound_faces(m);
  expect_nothing_rejoinable(m);
  expect_no_overlap(m);
  expect_modellers_order(m);
  expect_closed(m, 5000, .01);
  for (int storey = 1; storey <= 3; ++storey) {
    std::set<std::string> rooms;
    const std::string prefix = "floor" + std::to_string(storey) + "/";
    for (const GeneratedGroup& g : m.groups)
      if (g.name.starts_with(prefix) && g.name.ends_with("/floor")) rooms.insert(g.name);
    // The two stairwells and the atrium belong to all storeys.
    EXPECT_GE(rooms.size() + 3, 150u);
    EXPECT_LT(rooms.size() + 3, 165u);
  }
}

TEST(Bigger, AnyNumberOfRoomsFindsPlaceForItsDoors) {
  std::uint64_t before = 0;
  for (int rooms = 1; rooms < 250; rooms += 3) {
    const GeneratedModel m = generated({.kind = "building",
                                        .seed = static_cast<std::uint64_t>(rooms),
                                        .storeys = 2,
                                        .rooms = rooms});
    std::uint64_t floors = 0;
    for (const GeneratedGroup& g : m.groups) floors += g.name.ends_with("/floor");
    // Two storeys, of which stairwells and atrium have one floor only.
    EXPECT_GE(floors + 3, 2u * static_cast<std::uint64_t>(rooms));
    EXPECT_GE(m.counts().clusters, before);
    before = m.counts().clusters;
  }
}

TEST(Bigger, SmallestStoreyAndTallestTowerAreSound) {
  for (const GenerateOptions& o : {GenerateOptions{.kind = "floor", .rooms = 1},
                                   GenerateOptions{.kind = "building", .storeys = 12, .rooms = 1},
                                   GenerateOptions{.kind = "building", .storeys = 1}}) {
    const GeneratedModel m = generated(o);
    expect_sound_faces(m);
    expect_nothing_rejoinable(m);
    expect_no_overlap(m);
    expect_closed(m, 1000, .02);
  }
}

TEST(Campus, BuildingsStandApartInTheModellersOrder) {
  const GeneratedModel m = generated({.kind = "campus", .storeys = 2, .rooms = 30, .buildings = 3});
  expect_sound_faces(m);
  expect_no_overlap(m);
  expect_modellers_order(m);
  expect_closed(m, 2000, .02);
  std::map<std::string, Box> extents;
  for (std::size_t f = 0; f < m.faces.size(); ++f)
    extents[group_of(m, f).substr(0, 9)].extend(bounds(m.polygon(m.faces[f])));
  ASSERT_EQ(extents.size(), 3u);
  EXPECT_FALSE(extents["building1"].overlaps(extents["building2"]));
  EXPECT_FALSE(extents["building2"].overlaps(extents["building3"]));
}

}  // namespace
}  // namespace atrium
