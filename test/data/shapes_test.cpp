#include "data/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "data/dice.h"
#include "data/generate.h"

namespace atrium {
using namespace generator;
namespace {

long area_of(const std::vector<Rect>& rects) {
  long sum = 0;
  for (const Rect& r : rects) sum += long{r.a1 - r.a0} * (r.b1 - r.b0);
  return sum;
}

bool disjoint(const std::vector<Rect>& rects) {
  for (std::size_t i = 0; i < rects.size(); ++i)
    for (std::size_t j = i + 1; j < rects.size(); ++j)
      if (rects[i].overlaps(rects[j])) return false;
  return true;
}

// A rectangle with n notches in its lower edge has 2n reflex corners and n - 1 chords between
// neighbours: at least 2n - (n - 1) + 1 rectangles.
TEST(CutOut, RowOfDoorsLeavesTheLeastNumberOfPieces) {
  for (int n = 1; n < 6; ++n) {
    std::vector<Rect> doors;
    for (int i = 0; i < n; ++i) doors.push_back({1000 * i + 300, 1000 * i + 700, 0, 2100});
    const std::vector<Rect> pieces = cut_out({0, 1000 * n, 0, 2700}, doors);
    EXPECT_EQ(pieces.size(), static_cast<std::size_t>(n + 2));
    EXPECT_EQ(area_of(pieces), 1000l * n * 2700 - 400l * n * 2100);
    EXPECT_TRUE(disjoint(pieces));
  }
}

TEST(CutOut, HoleInTheMiddleLeavesFourPieces) {
  const Rect hole{400, 600, 400, 600};
  EXPECT_EQ(cut_out({0, 1000, 0, 1000}, std::span(&hole, 1)).size(), 4u);
}

TEST(CutOut, HoleAsWideAsTheWallLeavesTwo) {
  const Rect hole{0, 1000, 400, 600};
  EXPECT_EQ(cut_out({0, 1000, 0, 1000}, std::span(&hole, 1)).size(), 2u);
}

TEST(CutOut, HolesAtRandomKeepTheArea) {
  Dice dice(3, "holes");
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Rect> holes;
    for (int i = 0; i < 6; ++i) {
      const int a = dice.integer(0, 90), b = dice.integer(0, 90);
      const Rect h{a, a + dice.integer(1, 30), b, b + dice.integer(1, 30)};
      const bool apart =
          std::ranges::none_of(holes, [&](const Rect& other) { return other.overlaps(h); });
      if (apart) holes.push_back(h);
    }
    const Rect outer{0, 120, 0, 120};
    std::vector<Rect> all = cut_out(outer, holes);
    all.insert(all.end(), holes.begin(), holes.end());
    EXPECT_EQ(area_of(all), 120l * 120);
    EXPECT_TRUE(disjoint(all));
  }
}

// The outward area vectors of a closed solid add up to nothing, and Σ x·n dA = 3V.
void expect_solid(const GeneratedModel& m, double volume) {
  Vec3 sum(0);
  double flux = 0;
  for (const GeneratedFace& f : m.faces) {
    const PolygonView p = m.polygon(f);
    sum += area_vector(p) / 2.0;
    flux += dot(centroid(p), area_vector(p) / 2.0);
  }
  EXPECT_LT(length(sum), 1e-12);
  EXPECT_NEAR(flux / 3, volume, 1e-12);
}

TEST(Solids, TurnedBoxIsClosedAndFacesOutwards) {
  ModelBuilder out;
  out.begin("box");
  out.box(out.paint("grey", Spectrum(.5)), {-1, 0, 0}, {1, 3, .5}, kNoFace, placed({5, 6, 7}, 33));
  expect_solid(out.take("box"), 3);
}

TEST(Solids, PrismAndStumpHaveTheirVolumes) {
  ModelBuilder out;
  out.begin("prism");
  out.prism(out.paint("grey", Spectrum(.5)), std::vector<Vec2>{{0, 0}, {3, 0}, {0, 4}}, 1, 3);
  expect_solid(out.take("prism"), 12);

  ModelBuilder cone;
  cone.begin("stump");
  cone.stump(cone.paint("grey", Spectrum(.5)), {2, 1}, 4, 2, 0, 1, 3);
  // Square ends with half diagonals 2 and 1: areas 8 and 2, height 3: (8 + 2 + 4)·3/3.
  expect_solid(cone.take("stump"), 14);
}

TEST(WriteObj, TextReadsBackAsTheSameModel) {
  GenerateOptions options;
  options.kind = "cornell";
  const GeneratedModel model = *generate(options);
  const auto dir = std::filesystem::path(testing::TempDir());
  ASSERT_TRUE(write_obj(model, (dir / "read back.obj").string()).ok());

  std::ifstream file(dir / "read back.obj");
  std::vector<Vec3> vertices;
  std::vector<std::string> groups;
  std::vector<Vec3> corners;
  std::string line, paint;
  std::vector<std::string> paints;
  while (std::getline(file, line)) {
    std::istringstream in(line);
    std::string word;
    in >> word;
    if (word == "mtllib") {
      EXPECT_EQ(line, "mtllib read back.mtl");
    }
    if (word == "o") groups.push_back(line.substr(2));
    if (word == "usemtl") in >> paint;
    if (word == "v") {
      Vec3 v;
      in >> v.x >> v.y >> v.z;
      vertices.push_back(v);
    }
    if (word == "f") {
      for (std::size_t i; in >> i;) corners.push_back(vertices.at(i - 1));
      paints.push_back(paint);
    }
  }
  EXPECT_EQ(corners, model.vertices);
  ASSERT_EQ(groups.size(), model.groups.size());
  ASSERT_EQ(paints.size(), model.faces.size());
  for (std::size_t f = 0; f < paints.size(); ++f)
    EXPECT_EQ(paints[f], model.paints[model.faces[f].paint].name);
  EXPECT_TRUE(std::filesystem::exists(dir / "read back.mtl"));
}

TEST(WriteObj, FolderThatIsNotThereIsAStoreError) {
  GenerateOptions options;
  options.kind = "cornell";
  const Status status = write_obj(*generate(options), "/nowhere/at/all.obj");
  EXPECT_EQ(status.code(), Code::kStore);
  EXPECT_NE(status.message().find("/nowhere/at/all"), std::string::npos);
}

TEST(WriteObj, NameOfTheMaterialsIsRefusedForTheModel) {
  GenerateOptions options;
  options.kind = "cornell";
  EXPECT_EQ(write_obj(*generate(options), "room.mtl").code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium
