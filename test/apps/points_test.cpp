#include "apps/points.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

TEST(Points, HeaderMayOrderAndAddColumns) {
  const auto points = parse_points("nz, ny,nx,E,z,y,x\r\n1,0,0,9,3,2,1\r\n\r\n", "p.csv");
  ASSERT_TRUE(points.ok()) << points.status().message();
  ASSERT_EQ(points->size(), 1u);
  EXPECT_EQ((*points)[0].x, Vec3(1, 2, 3));
  EXPECT_EQ((*points)[0].normal, Vec3(0, 0, 1));
}

TEST(Points, BlanksAreAsGoodAsCommasAndTheLastLineNeedsNoEnd) {
  const auto points = parse_points("  1  2\t3 0 0 -1\n# a remark\n4,5,6,1,0,0,extra", "p.csv");
  ASSERT_TRUE(points.ok()) << points.status().message();
  ASSERT_EQ(points->size(), 2u);
  EXPECT_EQ((*points)[0].x, Vec3(1, 2, 3));
  EXPECT_EQ((*points)[1].normal, Vec3(1, 0, 0));
}

TEST(Points, WhatIsWrongIsNamedWithFileAndLine) {
  for (const char* text :
       {"1,2,3,0,0,1\n1,2,3,0,0,inf\n", "1,2,3,0,0,1\n1,2,3,0,0\n", "1,2,3,0,0,1\n1,2,3,0,0,0\n",
        "1,2,3,0,0,1\n1,2,,0,0,1\n", "1,2,3,0,0,1\n1,2,3,0,0,1x\n"}) {
    const auto points = parse_points(text, "p.csv");
    ASSERT_FALSE(points.ok()) << text;
    EXPECT_EQ(points.status().code(), Code::kUsage);
    EXPECT_EQ(points.status().file(), "p.csv");
    EXPECT_EQ(points.status().place(), "line 2") << text;
  }
}

TEST(Points, NothingIsNoPoints) {
  const auto points = parse_points("", "p.csv");
  ASSERT_TRUE(points.ok());
  EXPECT_TRUE(points->empty());
}

}  // namespace
}  // namespace atrium
