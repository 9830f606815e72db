#include "scheduler/run_state.h"

#include <gtest/gtest.h>

#include <numeric>

namespace atrium {
namespace {

constexpr std::size_t kSteps = WorkingSetCourse::kMostSteps;

TEST(WorkingSetCourse, FewGathersHaveAStepEach) {
  WorkingSetCourse course;
  for (const std::uint64_t gather : {0u, 1u, 2u}) course.add(gather, 3, 100 + gather);
  for (const std::size_t step : {0u, 1u, 2u}) {
    EXPECT_EQ(course.largest[step], 100 + step);
    EXPECT_EQ(course.gathers[step], 1u);
  }
  EXPECT_EQ(course.gathers[3], 0u);
}

// Half as many again as there are steps: of one gather and of two, in turn.
TEST(WorkingSetCourse, ManyGathersShareSteps) {
  constexpr std::uint64_t kAll = kSteps * 3 / 2;
  WorkingSetCourse course;
  for (std::uint64_t gather = 0; gather < kAll; ++gather) course.add(gather, kAll, gather);
  EXPECT_EQ(std::accumulate(course.gathers.begin(), course.gathers.end(), std::uint64_t{0}), kAll);
  EXPECT_EQ(course.gathers[0], 2u);
  EXPECT_EQ(course.gathers[1], 1u);
  EXPECT_EQ(course.sum[0], 0u + 1u);
  EXPECT_EQ(course.largest[0], 1u);
  EXPECT_EQ(course.largest[kSteps - 1], kAll - 1) << "the last gather is in the last step";
}

}  // namespace
}  // namespace atrium
