#include <gtest/gtest.h>

#include <sstream>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

constexpr double kTolerance = 0.02 * kFurnaceRadiosity;  // what solve was asked for, the default

using Row = std::vector<std::string>;

std::vector<Row> rows_of(const std::string& csv) {
  std::vector<Row> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

// On the cube's floor, on a wall, and in the air.
std::string three_points() {
  return "x,y,z,nx,ny,nz,Er\n0.5,0.5,0,0,0,2,7\n0,0.25,0.3333333333333333,1,0,0,7\n"
         "0.5,0.5,0.5,0,0,1,7\n";
}

TEST(Probe, FurnaceIsEvenOnSurfacesAndInTheAir) {
  const Ended e = run({"probe", furnace_run(), "-"}, "", three_points());
  ASSERT_EQ(e.code, 0) << e.err;
  const std::vector<Row> rows = rows_of(e.out);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(e.out.substr(0, e.out.find('\n')), "x,y,z,nx,ny,nz,Er,Eg,Eb,Br,Bg,Bb,cluster,cell");
  for (std::size_t r = 1; r < 4; ++r) {
    ASSERT_EQ(rows[r].size(), 14u) << e.out;
    for (std::size_t c = 6; c < 9; ++c)
      EXPECT_NEAR(std::stod(rows[r][c]), kFurnaceRadiosity, kTolerance) << e.out;
  }
  for (std::size_t r = 1; r < 3; ++r) {
    for (std::size_t c = 9; c < 12; ++c)
      EXPECT_NEAR(std::stod(rows[r][c]), kFurnaceRadiosity, kTolerance) << e.out;
    EXPECT_GE(std::stoi(rows[r][12]), 0);
    EXPECT_GE(std::stoi(rows[r][13]), 0);
  }
  for (std::size_t c = 9; c < 12; ++c) EXPECT_EQ(rows[3][c], "");
  EXPECT_EQ(rows[3][12], "-1");
  EXPECT_EQ(rows[3][13], "-1");
  // The columns come back as they went in, the normal unscaled, at 17 digits.
  EXPECT_EQ(rows[1][5], "2");
  EXPECT_EQ(rows[2][2], "0.33333333333333331");
}

TEST(Probe, AnswersKeepTheInputsOrderAndPlainNumbersDo) {
  const std::string floor = "0.5 0.5 0 0 0 1\n", wall = "0 0.25 0.25 1 0 0\n";
  const Ended one = run({"probe", furnace_run()}, "", floor + wall + floor);
  const Ended other = run({"probe", furnace_run()}, "", wall + floor + floor);
  ASSERT_EQ(one.code, 0) << one.err;
  const std::vector<Row> a = rows_of(one.out), b = rows_of(other.out);
  ASSERT_EQ(a.size(), 4u);
  EXPECT_EQ(a[1], b[2]);
  EXPECT_EQ(a[2], b[1]);
  EXPECT_EQ(a[3], a[1]);
}

TEST(Probe, TheNormalChoosesTheSideAndFarPointsAreInTheAir) {
  // Behind the floor there is nothing: no surface that faces that way.
  const Ended e = run({"probe", furnace_run()}, "", "0.5,0.5,0,0,0,-1\n0.5,0.5,0.01,0,0,1\n");
  ASSERT_EQ(e.code, 0) << e.err;
  const std::vector<Row> rows = rows_of(e.out);
  EXPECT_EQ(rows[1][12], "-1");
  EXPECT_EQ(rows[2][12], "-1");
}

TEST(Probe, FinalGatherAgreesWithTheElements) {
  const Ended e = run({"probe", furnace_run(), "--final-gather", "1000"}, "", three_points());
  ASSERT_EQ(e.code, 0) << e.err;
  for (const Row& row : rows_of(e.out)) {
    if (row[0] == "x") continue;
    EXPECT_NEAR(std::stod(row[6]), kFurnaceRadiosity, kTolerance);
  }
}

TEST(Probe, JsonIsOneDocument) {
  const Ended e = run({"probe", furnace_run(), "--json"}, "", three_points());
  ASSERT_EQ(e.code, 0) << e.err;
  const auto json = nlohmann::json::parse(e.out);
  ASSERT_EQ(json["points"].size(), 3u);
  EXPECT_TRUE(json["points"][2]["B"].is_null());
}

TEST(Probe, WrongPointsAreNamedByTheirLine) {
  const Ended letter = run({"probe", furnace_run()}, "", "0,0,0,0,0,1\n0,0,zero,0,0,1\n");
  EXPECT_EQ(letter.code, 2);
  EXPECT_NE(letter.err.find("line 2"), std::string::npos) << letter.err;
  EXPECT_EQ(run({"probe", furnace_run()}, "", "0,0,0,0,0\n").code, 2);
  EXPECT_EQ(run({"probe", furnace_run()}, "", "0,0,0,0,0,0\n").code, 2);
  EXPECT_EQ(run({"probe", furnace_run()}, "", "0,0,0,0,0,nan\n").code, 2);
  EXPECT_EQ(run({"probe", furnace_run()}, "", "x,y,z,nx,ny\n0,0,0,0,0\n").code, 2);
  EXPECT_EQ(run({"probe", furnace_run(), "no/such/points.csv"}).code, 2);
}

}  // namespace
}  // namespace atrium::testing
