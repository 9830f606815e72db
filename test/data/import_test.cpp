// The generator and import must agree on what a model holds: import welds, rejoins and resolves
// overlaps by means of its own, and finds nothing to do.
#include <gtest/gtest.h>

#include <filesystem>

#include "engine/import/import.h"
#include "test/data/model_checks.h"

namespace atrium {
namespace {

class Imported : public testing::TestWithParam<GenerateOptions> {};

TEST_P(Imported, ModelKeepsItsCountsAreaAndFronts) {
  const GeneratedModel m = generated(GetParam());
  // A file of its own: the cases may run side by side.
  std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::ranges::replace(name, '/', '_');
  const auto path = std::filesystem::path(testing::TempDir()) / (name + ".obj");
  ASSERT_TRUE(write_obj(m, path.string()).ok());
  ImportOptions import;
  import.files = {path.string()};
  const Result<Scene> scene = import_scene(import);
  ASSERT_TRUE(scene.ok()) << scene.status().message();
  EXPECT_EQ(scene->polygons, m.counts().patches);
  EXPECT_EQ(scene->patches, m.counts().patches);
  EXPECT_EQ(scene->lights, m.counts().lights);
  ASSERT_EQ(scene->objects.size(), m.groups.size());
  for (std::size_t g = 0; g < m.groups.size(); ++g)
    EXPECT_EQ(scene->objects[g].name, m.groups[g].name);
  double before = 0, after = 0;
  for (const GeneratedFace& f : m.faces) before += area(m.polygon(f));
  for (const Surface& s : scene->surfaces) after += area(scene->polygon(s));
  EXPECT_NEAR(after, before, 1e-9 * before);
  // Every front counts. What is closed has no lit back: rooms, and solids that touch nothing.
  for (const Surface& surface : scene->surfaces) {
    const std::string& object = scene->objects[surface.object.value].name;
    EXPECT_TRUE(surface.sides & kFront) << object;
    const bool closed = object.find("/wall_") != std::string::npos || object.ends_with("/floor") ||
                        object.ends_with("/ceiling") || object.ends_with("/reveal") ||
                        object.find("/lamp") != std::string::npos;
    if (closed) {
      EXPECT_EQ(surface.sides, kFront) << object;
    }
  }
  for (const Warning& w : scene->warnings) {
    const bool expected = w.what.starts_with("sides:") || w.what.starts_with("the brightest lamp");
    EXPECT_TRUE(expected) << w.count << " × " << w.what;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, Imported,
    testing::Values(GenerateOptions{.kind = "cornell"},
                    GenerateOptions{.kind = "furnace", .shape = "l-room"},
                    GenerateOptions{.kind = "furnace", .shape = "grid3x3"},
                    GenerateOptions{.kind = "rooms", .grid = 3}, GenerateOptions{.kind = "office"},
                    GenerateOptions{.kind = "office-low"}, GenerateOptions{.kind = "office-high"},
                    GenerateOptions{.kind = "floor"}, GenerateOptions{.kind = "building"}),
    [](const auto& test) {
      std::string name = test.param.kind + test.param.shape.value_or("");
      std::erase(name, '-');
      return name;
    });

}  // namespace
}  // namespace atrium
