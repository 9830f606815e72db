#include "bench/paper_report/figures.h"

#include <gtest/gtest.h>

#include "test/bench/runs.h"

namespace atrium::testing {
namespace {

// A figure a patch is printed to so many digits as the paper has; one of its seconds is cut off.
constexpr double kPrinted = .1;

TEST(PaperFigures, AgreeWithEachOther) {
  for (const ModelFigures& m : paper_models()) {
    EXPECT_NEAR(*m.links / *m.patches, *m.links_a_patch, 1) << m.model;
    EXPECT_NEAR(*m.elements / *m.patches, *m.elements_a_patch, kPrinted) << m.model;
    EXPECT_NEAR(*m.seconds / *m.patches, *m.seconds_a_patch, kPrinted) << m.model;
  }
  const ModelFigures& building = paper_models().back();
  const IterationFigures& all = paper_iterations().back();
  EXPECT_EQ(building.elements, all.elements);
  EXPECT_EQ(building.links, all.links);
  EXPECT_EQ(building.set_mb, all.set_mb);
  EXPECT_EQ(building.seconds, all.seconds);
  EXPECT_EQ(building.patches, paper_iterations().front().elements);
}

TEST(ModelFigures, AreThoseOfInputAndSummary) {
  SceneReport scene;
  scene.clusters = 3;
  scene.patches = 50;
  scene.lights = 2;
  const ModelFigures m = model_figures("Office", scene, two_iterations());
  EXPECT_EQ(m.clusters, 3) << "of the input, not the partition's 4";
  EXPECT_EQ(m.set_mb, 7);
  EXPECT_EQ(m.total_mb, 30);
  EXPECT_EQ(m.links_a_patch, 2000.0 / 50);
  EXPECT_EQ(m.elements_a_patch, 200.0 / 50);
  EXPECT_EQ(m.seconds_a_patch, 6.0 / 50);
}

TEST(OrderFigures, AreThoseOfTheLastCompleteIteration) {
  RunData run = two_iterations();
  run.history.push_back(iteration(3, 5.5, 1e6));
  run.history.back().clusters_gathered = 1;
  const OrderFigures o = order_figures("cell", run);
  EXPECT_EQ(o.reads, 20);
  EXPECT_EQ(o.read_mb, 4);
  EXPECT_EQ(o.hit_ratio, .75);
  EXPECT_EQ(o.io_seconds, .5);
  EXPECT_EQ(o.seconds, 2) << "from the end of the iteration before";
}

TEST(IterationFigures, GoFromTheInputToAllOfThem) {
  ModelFigures model;
  model.patches = 50;
  const std::vector<IterationFigures> rows = iteration_figures(model, two_iterations());
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].iteration, 0);
  EXPECT_EQ(rows[0].elements, 50);
  EXPECT_FALSE(rows[0].links);
  EXPECT_EQ(rows[1].seconds, 3);
  EXPECT_EQ(rows[2].seconds, 2);
  EXPECT_EQ(rows[2].set_mb, 4);
  EXPECT_FALSE(rows[3].iteration);
  EXPECT_EQ(rows[3].set_mb, 7);
  EXPECT_EQ(rows[3].seconds, 6);
}

TEST(FullestIteration, IsTheOneWithTheLargestWorkingSet) {
  EXPECT_EQ(fullest_iteration(two_iterations())->iteration, 1);
  RunData older = two_iterations();
  for (HistoryEntry& e : older.history) e.largest_working_sets.clear();
  EXPECT_FALSE(fullest_iteration(older)) << "of runs that do not tell";
}

// 8.7 in the paper: 12.2 of Building to 1.4 of Office.
TEST(SpreadOfSecondsAPatch, IsTheMostByTheFewest) {
  EXPECT_NEAR(*spread_of_seconds_a_patch(paper_models()), 12.2 / 1.4, 1e-12);
  EXPECT_FALSE(spread_of_seconds_a_patch({}));
}

}  // namespace
}  // namespace atrium::testing
