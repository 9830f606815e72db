// The suites' functions: that they pass what is right, and above all that they do not pass what was
// planted wrong.
#include "apps/validation/suites.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "apps/report_json.h"
#include "apps/validation/agreement.h"
#include "apps/validation/solved_scene.h"
#include "apps/validation/test_rooms.h"
#include "test/agree/run.h"

namespace atrium::testing {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string failures(const Validation& v) {
  std::string names;
  for (const ValidationCase& c : v.cases)
    if (!c.pass) names += c.name + "\n";
  for (const std::string& e : v.examples) names += e + "\n";
  return names;
}

int failed(const Validation& v) {
  return static_cast<int>(
      std::count_if(v.cases.begin(), v.cases.end(), [](const auto& c) { return !c.pass; }));
}

TEST(ValidationCase, WhatIsNoNumberNeverPasses) {
  EXPECT_TRUE(within("", 1, 1.1, .11).pass);
  EXPECT_FALSE(within("", 1, 1.1, .09).pass);
  EXPECT_FALSE(within("", 1, .9, .09).pass);
  EXPECT_FALSE(within("", 0, kNaN, 1).pass);
  EXPECT_TRUE(at_most("", 12, 12).pass);
  EXPECT_FALSE(at_most("", 12, 13).pass);
  EXPECT_FALSE(at_most("", 12, kNaN).pass);
  EXPECT_FALSE(Validation{}.pass());
  EXPECT_TRUE(std::isnan(worse(kNaN, 1)));
  EXPECT_TRUE(std::isnan(worse(1, kNaN)));
}

// By hand: the mean expected is 2, so the errors are 1/2, 0 and 2/4; √((1/4 + 1/4)/3).
TEST(Agreement, DifferencesOverTheLargerOfThePointAndTheMean) {
  const std::vector<double> expected{0, 2, 4}, found{1, 2, 2};
  EXPECT_NEAR(nrmse(found, expected), std::sqrt(0.5 / 3), 1e-15);
  EXPECT_EQ(nrmse(expected, expected), 0);
  EXPECT_TRUE(std::isnan(nrmse(std::vector<double>{0, kNaN, 4}, expected)));
  EXPECT_TRUE(std::isnan(nrmse(std::vector<double>{0, 0}, std::vector<double>{0, 0})));
}

TEST(FormFactorSuite, TheSolversPassAndOnesAMillionthOffDoNot) {
  const Result<Validation> right = judge_form_factors({});
  ASSERT_TRUE(right.ok());
  EXPECT_TRUE(right->pass()) << failures(*right);

  constexpr double kOff = 1 + 1e-6;
  FormFactorMethods planted;
  planted.between = [](PolygonView p, PolygonView q) {
    Result<PolygonFormFactors> f = polygon_to_polygon(p, q);
    if (f.ok()) f->f12 *= kOff;
    return f;
  };
  const Result<Validation> polygons = judge_form_factors(planted);
  ASSERT_TRUE(polygons.ok());
  // All but those that are 0, and the long strips, of which crossed strings know less.
  EXPECT_GE(failed(*polygons), 20);

  planted = {};
  planted.from_point = [](const Vec3& x, const Vec3& n, PolygonView q) {
    return kOff * point_to_polygon(x, n, q);
  };
  const Result<Validation> points = judge_form_factors(planted);
  ASSERT_TRUE(points.ok());
  EXPECT_GE(failed(*points), 9);
}

constexpr double kExitance = 100, kRho = .5, kRadiosity = kExitance / (1 - kRho);

GeneratedModel cube() {
  return generated({.kind = "furnace", .rho = kRho, .exitance = kExitance, .shape = "cube"});
}

TEST(FurnaceSuite, EveryBasisInACube) {
  for (int basis = 1; basis <= kMaxOrder; ++basis) {
    Validation v;
    ASSERT_TRUE(judge_furnace("cube", cube(), kRadiosity, basis, v).ok());
    EXPECT_TRUE(v.pass()) << failures(v);
  }
}

TEST(FurnaceSuite, AnotherRadiosityOrOneDarkerWallFails) {
  Validation v;
  constexpr double kOff = 1.0002;  // twice what is allowed
  ASSERT_TRUE(judge_furnace("cube", cube(), kOff * kRadiosity, kUsualBasis, v).ok());
  EXPECT_FALSE(v.pass());

  GeneratedModel spoilt = cube();
  spoilt.paints.push_back(spoilt.paints.front());
  spoilt.paints.back().name = "darker";
  spoilt.paints.back().reflectance = Spectrum{kRho - .01};
  spoilt.faces.front().paint = static_cast<PaintId>(spoilt.paints.size() - 1);
  v = {};
  ASSERT_TRUE(judge_furnace("cube", spoilt, kRadiosity, kUsualBasis, v).ok());
  EXPECT_FALSE(v.pass());
}

TEST(FurnaceSuite, ALampLitRoomAndOneOfAnotherReflectance) {
  const Vec3 size{3, 3, 3};
  const GeneratedModel room = lamp_lit_room(kRho, size, middle_of(size, 1), 1000);
  EXPECT_NEAR(flux_of(room), 1000, 1e-9);
  Validation v;
  ASSERT_TRUE(judge_lamp_lit("room", room, kRho, kUsualBasis, v).ok());
  EXPECT_EQ(v.cases.size(), 2u);
  EXPECT_TRUE(v.pass()) << failures(v);
  v = {};
  ASSERT_TRUE(judge_lamp_lit("room", room, kRho + .1, kUsualBasis, v).ok());
  EXPECT_FALSE(v.pass());
}

// A room without a lamp is no failure of the suite's, but one of its case.
TEST(FurnaceSuite, WhatCannotBeSolvedFailsAndSaysWhy) {
  const Vec3 size{3, 3, 3};
  Validation v;
  ASSERT_TRUE(
      judge_lamp_lit("dark", lamp_lit_room(kRho, size, middle_of(size, 1), 0), kRho, kUsualBasis, v)
          .ok());
  ASSERT_EQ(v.cases.size(), 1u);
  EXPECT_FALSE(v.pass());
  ASSERT_EQ(v.examples.size(), 1u);
  EXPECT_EQ(v.examples[0].rfind("dark: ", 0), 0u) << v.examples[0];
}

TEST(Cie171Suite, AreaSourceAlongTheFloor) {
  Validation v;
  ASSERT_TRUE(judge_area_source(kUsualBasis, v).ok());
  ASSERT_EQ(v.cases.size(), 4u);
  EXPECT_TRUE(v.pass()) << failures(v);
  const double known[] = {61.42, 79.26, 95.67, 105.78};  // lx, to two places
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(v.cases[i].expected, known[i], .005);
}

TEST(SolvedScene, APointIsJudgedAndOneInTheAirFails) {
  const Vec3 size{3, 3, 3};
  const auto scene =
      SolvedScene::make(lamp_lit_room(0, size, middle_of(size, 1), 1000), asking(.05, kUsualBasis));
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  const SurfaceProbe floor{{1.5, 1.5, 0}, {0, 0, 1}}, air{{1.5, 1.5, 1}, {0, 0, 1}};
  const auto sample = (*scene)->at(floor);
  ASSERT_TRUE(sample.ok() && sample->has_value());
  const double e = luminance((*sample)->irradiance);
  Validation v;
  ASSERT_TRUE(judge_illuminance("as it is", **scene, floor, e, 1e-9 * e, v).ok());
  EXPECT_TRUE(v.pass());
  ASSERT_TRUE(judge_illuminance("planted", **scene, floor, 1.02 * e, .01 * e, v).ok());
  EXPECT_FALSE(v.cases.back().pass);
  ASSERT_TRUE(judge_illuminance("in the air", **scene, air, e, e, v).ok());
  EXPECT_FALSE(v.cases.back().pass);
  EXPECT_EQ(v.examples.size(), 1u);
}

TEST(SolvedScene, LeavesNothingBehind) {
  const Folder folder;
  const char* before = getenv("TMPDIR");
  const std::string was = before ? before : "";
  const std::string mine = folder / "";
  ASSERT_EQ(setenv("TMPDIR", mine.c_str(), 1), 0);
  {
    const auto scene = SolvedScene::make(cube(), asking(.5, kUsualBasis));
    EXPECT_TRUE(scene.ok());
    EXPECT_FALSE(std::filesystem::is_empty(mine));
  }
  EXPECT_TRUE(std::filesystem::is_empty(mine));
  before ? setenv("TMPDIR", was.c_str(), 1) : unsetenv("TMPDIR");
}

// A unit triangle and a rectangle of six times its area.
TEST(PointsByArea, AreOnTheFacesAndAsManyAsTheirAreas) {
  generator::ModelBuilder out;
  const PaintId grey = out.paint("grey", Spectrum{.5});
  out.begin("triangle");
  out.face(grey, {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}});
  out.begin("rectangle");
  out.rectangle(grey, 2, -1, {0, 0, 0}, {3, 1, 0});
  constexpr int kCount = 7000;
  int above = 0, first_half = 0;
  double x = 0;
  for (const SurfaceProbe& p : points_by_area(out.take("two faces"), kCount)) {
    if (p.x.z == 1) {
      ++above;
      EXPECT_TRUE(p.x.x >= 0 && p.x.y >= 0 && p.x.x + p.x.y <= 1 + 1e-12);
      EXPECT_EQ(p.normal, (Vec3{0, 0, 1}));
    } else {
      EXPECT_TRUE(p.x.x >= 0 && p.x.x <= 3 && p.x.y >= 0 && p.x.y <= 1);
      EXPECT_EQ(p.normal, (Vec3{0, 0, -1}));
      x += p.x.x;
      first_half += p.x.x / 3 < p.x.y;  // the other side of the diagonal
    }
  }
  // Binomial: a standard deviation of 29 and of 39; of the mean of x .011.
  EXPECT_NEAR(above, kCount / 7, 5 * 29);
  EXPECT_NEAR(first_half, kCount * 3 / 7, 5 * 39);
  EXPECT_NEAR(x / (kCount - above), 1.5, 5 * .011);
}

TEST(ValidationsJson, OneDocumentThatPassesWhereAllDo) {
  Validation good, bad;
  good.suite = "good";
  good.cases = {within("a", 1, 1, 0)};
  bad.suite = "bad";
  bad.cases = {within("b", 1, kNaN, 0)};
  const auto both = nlohmann::json::parse(validations_json({good, bad}));
  EXPECT_EQ(both["pass"], false);
  ASSERT_EQ(both["suites"].size(), 2u);
  EXPECT_EQ(both["suites"][0]["pass"], true);
  EXPECT_EQ(both["suites"][1]["cases"][0]["pass"], false);
  EXPECT_TRUE(both["suites"][1]["cases"][0]["found"].is_null());
  EXPECT_EQ(nlohmann::json::parse(validations_json({good}))["pass"], true);
}

}  // namespace
}  // namespace atrium::testing
