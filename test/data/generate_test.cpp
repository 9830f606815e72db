// The small scenes, and what the options do.
#include "data/generate.h"

#include <gtest/gtest.h>

#include "test/data/model_checks.h"

namespace atrium {
namespace {

GenerateOptions kind(const std::string& name) {
  GenerateOptions o;
  o.kind = name;
  return o;
}

bool same(const GeneratedModel& a, const GeneratedModel& b) {
  return a.vertices == b.vertices && a.faces.size() == b.faces.size() &&
         a.groups.size() == b.groups.size();
}

TEST(Cornell, RoomIsClosedAndSound) {
  const GeneratedModel m = generated(kind("cornell"));
  expect_sound_faces(m);
  expect_nothing_rejoinable(m);
  expect_no_overlap(m);
  EXPECT_LT(length(net_area(m) - Vec3(0, 0, 2 * 1.65 * 1.65)), 1e-12);  // the boxes' bottoms
  expect_modellers_order(m);
  expect_closed(m, 2000, .05);  // two boxes of 1.65² m² on some 200 m²
  EXPECT_EQ(m.counts().lights, 1u);
  EXPECT_EQ(m.counts().clusters, 9u);
}

TEST(Cornell, SeedMovesTheBoxesAndNothingElse) {
  GenerateOptions one = kind("cornell"), two = one;
  two.seed = 2;
  EXPECT_TRUE(same(generated(one), generated(one)));
  EXPECT_FALSE(same(generated(one), generated(two)));
  EXPECT_EQ(generated(one).counts().patches, generated(two).counts().patches);
}

class Furnace : public testing::TestWithParam<const char*> {};

TEST_P(Furnace, IsClosedWithOnePaintOfTheGivenExitance) {
  GenerateOptions o = kind("furnace");
  o.shape = GetParam();
  o.rho = .75;
  o.exitance = 200;
  const GeneratedModel m = generated(o);
  expect_sound_faces(m);
  expect_nothing_rejoinable(m);
  expect_no_overlap(m);
  EXPECT_LT(length(net_area(m)), 1e-12);
  expect_closed(m, 2000, 0);
  ASSERT_EQ(m.paints.size(), 1u);
  // Flux: M·A; and B = M ÷ (1 − ρ) balances at any point: B = M + ρB.
  const double exitance = m.paints[0].luminance.x * std::numbers::pi;
  EXPECT_NEAR(exitance, 200, 200 * 1e-15);
  const double b = exitance / (1 - m.paints[0].reflectance.x);
  EXPECT_NEAR(b, 800, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Furnace,
                         testing::Values("cube", "l-room", "two-rooms", "grid3x3"));

TEST(Furnace, CubeHasTheAreaOfACube) {
  const GeneratedModel m = generated(kind("furnace"));
  double total = 0;
  for (const GeneratedFace& f : m.faces) total += area(m.polygon(f));
  EXPECT_NEAR(total, 6 * 9, 1e-12);
}

// The bottoms that boxes lack are as large as their tops.
double missing_below(const GeneratedModel& m) {
  double sum = 0;
  for (std::size_t f = 0; f < m.faces.size(); ++f) {
    const Vec3 n = area_vector(m.polygon(m.faces[f])) / 2.0;
    if (group_of(m, f).find("/furniture/box") != std::string::npos && n.z > 0) sum += n.z;
  }
  return sum;
}

TEST(Rooms, GridOfKHasKTimesKRoomsWithDoorwaysLampsAndBoxes) {
  for (int k : {1, 2, 5}) {
    GenerateOptions o = kind("rooms");
    o.grid = k;
    const GeneratedModel m = generated(o);
    const auto rooms = static_cast<std::uint64_t>(k * k);
    const auto doors = static_cast<std::uint64_t>(2 * k * (k - 1));
    // Floor, ceiling, four walls, a lamp, three boxes a room; a reveal a doorway.
    EXPECT_EQ(m.counts().clusters, rooms * 10 + doors);
    // A wall with a doorway is three faces, and each doorway is in two walls.
    EXPECT_EQ(m.counts().patches, rooms * (6 + 6 + 15) + doors * (2 * 2 + 4));
    EXPECT_EQ(m.counts().lights, rooms);
    expect_sound_faces(m);
    expect_nothing_rejoinable(m);
    expect_no_overlap(m);
    EXPECT_LT(length(net_area(m) - Vec3(0, 0, missing_below(m))), 1e-10);
    expect_modellers_order(m);
    expect_closed(m, 2000, .06);
  }
}

TEST(Rooms, GivenReflectanceIsEverySurfaces) {
  GenerateOptions o = kind("rooms");
  o.rho = .9;
  for (const Paint& p : generated(o).paints) EXPECT_EQ(p.reflectance, Spectrum(.9)) << p.name;
}

TEST(Options, WhatTheKindDoesNotKnowIsRefused) {
  GenerateOptions o = kind("cornell");
  o.grid = 3;
  EXPECT_EQ(generate(o).status().code(), Code::kUsage);
  EXPECT_EQ(generate(kind("cathedral")).status().code(), Code::kUsage);
  o = kind("furnace");
  o.shape = "sphere";
  EXPECT_EQ(generate(o).status().code(), Code::kUsage);
}

TEST(Options, ValuesOutOfRangeAreRefused) {
  for (double rho : {-.1, 1.0, 2.0, std::nan("")}) {
    GenerateOptions o = kind("furnace");
    o.rho = rho;
    EXPECT_EQ(generate(o).status().code(), Code::kUsage) << rho;
  }
  for (double m : {-1.0, 0.0, std::nan(""), HUGE_VAL}) {
    GenerateOptions o = kind("furnace");
    o.exitance = m;
    EXPECT_EQ(generate(o).status().code(), Code::kUsage) << m;
  }
  for (int k : {-1, 0, 1000000}) {
    GenerateOptions o = kind("rooms");
    o.grid = k;
    EXPECT_EQ(generate(o).status().code(), Code::kUsage) << k;
  }
}

TEST(Options, ModelTooBigForMemoryIsRefusedBeforeItIsMade) {
  GenerateOptions o = kind("campus");
  o.buildings = 500;
  o.storeys = 100;
  EXPECT_EQ(generate(o).status().code(), Code::kUsage);
}

TEST(Options, AlmostAllReflectingIsTakenAsItIs) {
  GenerateOptions o = kind("furnace");
  o.rho = .99999;
  EXPECT_EQ(generated(o).paints[0].reflectance.x, .99999);
}

}  // namespace
}  // namespace atrium
