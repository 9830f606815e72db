#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

constexpr double kSigmas = 4;

using Row = std::vector<double>;

constexpr const char* kHeader = "x,y,z,nx,ny,nz,Er,Eg,Eb,seEr,seEg,seEb";

std::vector<Row> rows_of(const std::string& csv) {
  std::vector<Row> rows;
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, kHeader);
  while (std::getline(lines, line)) {
    rows.emplace_back();
    std::istringstream fields(line);
    for (std::string field; std::getline(fields, field, ',');)
      rows.back().push_back(std::stod(field));
    EXPECT_EQ(rows.back().size(), 12u) << line;
  }
  return rows;
}

// A cube of 3 units, ρ = 1/2, M = 100 lm/m²: E = 200 lx all over.
class Reference : public ::testing::Test {
 protected:
  void SetUp() override {
    const Ended made = run({"gen", "furnace", "--rho", "0.5", "--emit", "100", "-o", scene()});
    ASSERT_EQ(made.code, 0) << made.err;
  }
  std::string scene() const { return folder_ / "cube.obj"; }
  std::string file(const std::string& name) const { return folder_ / name; }
  Ended reference(std::vector<std::string> more, const std::string& points = "") const {
    std::vector<std::string> words{"reference", scene()};
    words.insert(words.end(), more.begin(), more.end());
    return run(words, "", points);
  }

 private:
  Folder folder_;
};

void expect_furnace(const Row& row) {
  for (int c = 6; c < 9; ++c) {
    EXPECT_NEAR(row[c], kFurnaceRadiosity, kSigmas * row[c + 3]);
    EXPECT_LT(row[c + 3], 0.1 * kFurnaceRadiosity);
  }
}

TEST_F(Reference, PointsKeepTheirOrderAndFindTheFurnace) {
  const Ended e = reference({"-"},
                            "x,y,z,nx,ny,nz,Er\n0.5,0.5,0,0,0,2,7\n"
                            "0,0.25,0.3333333333333333,1,0,0,7\n0.5,0.5,0.5,0,0,1,7\n");
  ASSERT_EQ(e.code, 0) << e.err;
  const std::vector<Row> rows = rows_of(e.out);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0][5], 2);  // as it went in
  EXPECT_EQ(rows[1][2], 0.3333333333333333);
  EXPECT_EQ(rows[2][2], 0.5);
  for (const Row& row : rows) expect_furnace(row);
  EXPECT_NE(e.err.find("3 points, 3072 paths"), std::string::npos) << e.err;
}

TEST_F(Reference, APointAHairBehindItsSurfaceBelongsToIt) {
  const Ended e = reference({"-"}, "0.5,0.5,-1e-7,0,0,1\n");
  ASSERT_EQ(e.code, 0) << e.err;
  expect_furnace(rows_of(e.out).at(0));
}

TEST_F(Reference, UnitsAreTheScenes) {
  // The same cube in feet: the furnace does not care, the points must still lie on it.
  const Ended e = reference({"-", "--unit", "ft"}, "1.5,1.5,3,0,0,-1\n");
  ASSERT_EQ(e.code, 0) << e.err;
  expect_furnace(rows_of(e.out).at(0));
}

TEST_F(Reference, ThreadsChangeNoByteAndSeedsDo) {
  const std::string points = "0.5,0.5,0,0,0,1\n1,1,0,0,0,1\n2,0.5,0,0,0,1\n";
  const Ended one = reference({"-", "--threads", "1"}, points);
  const Ended three = reference({"-", "--threads", "3"}, points);
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_EQ(one.out, three.out);
  EXPECT_NE(one.out, reference({"-", "--seed", "7"}, points).out);
}

TEST_F(Reference, DrawnPointsLieOnTheSurfacesAndMayBeReadAgain) {
  const Ended e = reference({"--draw", "40", "--noise", "5%", "-o", file("drawn.csv"), "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const auto json = nlohmann::json::parse(e.out);
  EXPECT_EQ(json["points"], 40);
  EXPECT_GT(json["rays"], json["paths"]);
  EXPECT_LE(json["noise"], 0.05);
  for (const char* key : {"seconds", "cpu_seconds"}) EXPECT_GE(json[key], 0) << key;
  const std::vector<Row> rows = rows_of(read_file(file("drawn.csv")));
  ASSERT_EQ(rows.size(), 40u);
  for (const Row& row : rows) {
    double off = kFurnaceSide;  // the nearest wall
    for (int k = 0; k < 3; ++k)
      off = std::min({off, std::abs(row[k]), std::abs(row[k] - kFurnaceSide)});
    EXPECT_LT(off, 1e-9);
    expect_furnace(row);
  }
  const Ended again = reference({file("drawn.csv"), "--samples", "64"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(rows_of(again.out).size(), 40u);
}

TEST_F(Reference, WhatCannotBeIsRefused) {
  EXPECT_EQ(reference({}).code, 2);  // no points
  EXPECT_EQ(reference({"no/such/points.csv"}).code, 2);
  EXPECT_EQ(reference({"-"}, "0,0,0,0,0,0\n").code, 2);
  EXPECT_EQ(reference({"-", "--samples", "0"}, "0,0,0,0,0,1\n").code, 2);
  EXPECT_EQ(reference({"-", "--noise", "0"}, "0,0,0,0,0,1\n").code, 2);
  EXPECT_EQ(reference({"-", "--noise", "1%", "--samples", "64"}, "0,0,0,0,0,1\n").code, 2);
  EXPECT_EQ(reference({"-", "--json"}, "0,0,0,0,0,1\n").code, 2);  // both to stdout
  EXPECT_EQ(run({"reference", "no/such/scene.obj", "-"}, "", "0,0,0,0,0,1\n").code, 3);
  write_file(file("dark.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  const Ended dark = run({"reference", file("dark.obj"), "-"}, "", "0.5,0.2,0,0,0,1\n");
  EXPECT_EQ(dark.code, 3);
  EXPECT_NE(dark.err.find("no light"), std::string::npos) << dark.err;
}

}  // namespace
}  // namespace atrium::testing
