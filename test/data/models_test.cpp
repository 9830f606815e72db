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
    expect_modellers_order(m);
    expect_closed(m, 2000, paper.covered);
  }
}

INSTANTIATE_TEST_SUITE_P(Tables2And3, PaperModels,
                         testing::Values(PaperModel{"office", 36, 127, 18, .005},
                                         PaperModel{"office-low", 70, 1418, 21, .05},
                                         PaperModel{"office-high", 70, 3466, 21, .05}),
                         [](const auto& test) {
                           std::string name = test.param.kind;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace atrium
