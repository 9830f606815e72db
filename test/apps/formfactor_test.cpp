#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

const char* const kSquare = "0 0 0;1 0 0;1 1 0;0 1 0";
const char* const kAbove = "0 0 1;0 1 1;1 1 1;1 0 1";

// [Howell C-11, a = b = c]
double parallel_unit_squares() {
  const double s = std::sqrt(2.0);
  return 2 / std::numbers::pi *
         (std::log(std::sqrt(4.0 / 3)) + 2 * s * std::atan(1 / s) - 2 * std::atan(1.0));
}

TEST(FormFactor, ParallelUnitSquaresAtUnitDistance) {
  const Ended e = run({"formfactor", kSquare, kAbove, "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json f = Json::parse(e.out);
  EXPECT_NEAR(f["F12"].get<double>(), parallel_unit_squares(), 1e-9);
  EXPECT_NEAR(f["F21"].get<double>(), parallel_unit_squares(), 1e-9);
  EXPECT_DOUBLE_EQ(f["A1"].get<double>(), 1);
  EXPECT_DOUBLE_EQ(f["A2"].get<double>(), 1);
}

// A point over the middle of a square of side 2 at distance 1, facing it: four times the factor of
// a quarter at its corner, (2 / 2π) · (1/√2) atan(1/√2). [Howell B-3]
TEST(FormFactor, PointFacingASquareHasNoOtherWay) {
  const Ended e =
      run({"formfactor", "-.5 0 0;0 0 2", "-1.5 -1 1;-1.5 1 1;0.5 1 1;0.5 -1 1", "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json f = Json::parse(e.out);
  const double s = std::sqrt(2.0);
  const double quarter = 2 / (2 * std::numbers::pi) / s * std::atan(1 / s);
  EXPECT_NEAR(f["F12"].get<double>(), 4 * quarter, 1e-9);
  EXPECT_TRUE(f["F21"].is_null());
  EXPECT_TRUE(f["A1"].is_null());
  EXPECT_DOUBLE_EQ(f["A2"].get<double>(), 4);
}

TEST(FormFactor, WhatIsNoPolygonIsAUsageError) {
  EXPECT_EQ(run({"formfactor", kSquare}).code, 2);
  EXPECT_EQ(run({"formfactor", kSquare, "0 0 1;0 1 x;1 1 1"}).code, 2);
  EXPECT_EQ(run({"formfactor", kSquare, "0 0 1;0 1 1;0 2 1"}).code, 2);
  EXPECT_EQ(run({"formfactor", "0 0 0;0 0 0", kAbove}).code, 2);
}

}  // namespace
}  // namespace atrium::testing
