// The partition on real scenes: random segments as judge, and how much it cuts and keeps.

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "engine/import/import.h"
#include "visibility/partition.h"
#include "visibility/soundness.h"

namespace atrium {
namespace {

constexpr std::uint64_t kSegments = 1'000'000;

struct SceneCase {
  std::string name;
  std::vector<std::string> files;
  std::vector<std::string> drop;
  double most_cut;   // patches a lit side
  double most_kept;  // of all cluster pairs
};

class PartitionOfScene : public ::testing::TestWithParam<SceneCase> {};

TEST_P(PartitionOfScene, KeepsWhatSegmentsWitnessAndLittleElse) {
  const SceneCase& c = GetParam();
  ImportOptions options;
  options.drop = c.drop;
  for (const std::string& f : c.files) {
    const std::string path = std::string(ATRIUM_SHARED_DIR) + "/scenes/" + f;
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
    options.files.push_back(path);
  }
  Result<Scene> scene = import_scene(options);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  Result<Model> model = partition(*scene);
  ASSERT_TRUE(model.ok()) << model.status().message();

  const SoundnessReport report = judge_visibility(*scene, *model, {.segments = kSegments});
  EXPECT_GT(report.joined, kSegments / 1000);
  EXPECT_EQ(report.violations(), 0u) << report.examples.front();

  const PartitionCounts n = count(*model);
  EXPECT_LE(double(n.lit_patches), c.most_cut * double(n.lit_sides));
  const double clusters = double(model->clusters.size());
  EXPECT_LE(double(n.visible_pairs), c.most_kept * clusters * clusters);

  for (std::uint32_t i = 0; i < model->clusters.size(); ++i)
    for (ClusterId j : model->visible[i]) {
      const auto row = model->visible[j.value];
      ASSERT_TRUE(std::binary_search(row.begin(), row.end(), ClusterId(i)));
    }
}

// A tenth above what was measured when this was written. Of its own, coarser clusters the prototype
// kept 6.5% for institute, 29% for duplex and 49% for hospital. [facts: visibility]
INSTANTIATE_TEST_SUITE_P(
    Shared, PartitionOfScene,
    ::testing::Values(
        SceneCase{"cornell_box", {"cornell_box/CornellBox-Original.obj"}, {}, 1.5, 0.34},
        SceneCase{"veach_ajar", {"veach_ajar/veach_ajar.obj"}, {}, 1.2, 0.49},
        SceneCase{"hospital", {"mgf_hospital/hospital.obj"}, {}, 1.2, 0.225},
        SceneCase{"institute",
                  {"institute/institute.obj", "institute/institute.lamps.obj"},
                  {"^DOOR_"},
                  1.5,
                  0.035},
        SceneCase{
            "duplex", {"duplex/duplex.obj", "duplex/duplex.lamps.obj"}, {"^DOOR_"}, 1.5, 0.044}),
    [](const auto& scene_case) { return scene_case.param.name; });

}  // namespace
}  // namespace atrium
