// The include direction, kept; and planted violations, found.
#include "test/layering/layering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

namespace atrium {
namespace {

// What is found in one file that has just this line.
std::vector<std::string> found_in(const std::string& path, const std::string& line) {
  const SourceFile source{path, line + "\n"};
  return layering_violations({&source, 1});
}

TEST(Layering, NoFileOfThisRepositoryIncludesAgainstTheDirection) {
  for (const std::string& violation : layering_violations(read_sources(ATRIUM_SOURCE_DIR)))
    ADD_FAILURE() << violation;
}

TEST(Layering, AllFoldersAreLookedAt) {
  const std::vector<SourceFile> sources = read_sources(ATRIUM_SOURCE_DIR);
  for (const std::string known :
       {"engine/vec.h", "pagestore/cluster_store.h", "visibility/tube.cpp", "solver/basis.h",
        "scheduler/order.cpp", "data/shapes.h", "apps/atrium.cpp", "test/layering/layering.cpp"}) {
    const auto at = std::ranges::find(sources, known, &SourceFile::path);
    ASSERT_NE(at, sources.end()) << known;
    EXPECT_FALSE(at->text.empty()) << known;
  }
}

TEST(Layering, LeftwardIncludesAreRight) {
  EXPECT_TRUE(found_in("solver/gather.cpp", "#include \"visibility/tube.h\"").empty());
  EXPECT_TRUE(found_in("scheduler/solve.cpp", "#include \"pagestore/cluster_store.h\"").empty());
  EXPECT_TRUE(found_in("apps/gen.cpp", "#include \"data/generate.h\"").empty());
  EXPECT_TRUE(found_in("engine/import/weld.h", "#include \"engine/vec.h\"").empty());
  EXPECT_TRUE(found_in("test/solver/refine_test.cpp", "#include \"data/generate.h\"").empty());
  EXPECT_TRUE(found_in("test/agree/orders_test.cpp", "#include \"scheduler/order.h\"").empty());
  EXPECT_TRUE(found_in("test/bench/figures_test.cpp", "#include \"bench/picture.h\"").empty());
}

TEST(Layering, RightwardIncludesAreFound) {
  for (const auto& [path, header] : std::vector<std::pair<std::string, std::string>>{
           {"engine/scene.h", "solver/basis.h"},
           {"pagestore/record.cpp", "visibility/tube.h"},
           {"pagestore/record.cpp", "solver/link.h"},
           {"visibility/tube.h", "solver/link.h"},
           {"visibility/tube.cpp", "pagestore/record.h"},
           {"solver/gather.cpp", "pagestore/cluster_store.h"},
           {"solver/gather.cpp", "scheduler/solve.h"},
           {"scheduler/solve.cpp", "apps/command.h"},
           {"scheduler/solve.cpp", "data/generate.h"},
           {"data/office.cpp", "visibility/bsp.h"},
           {"apps/solve.cpp", "test/layering/layering.h"},
           {"apps/report.cpp", "bench/picture.h"},
           {"test/apps/chart_test.cpp", "bench/picture.h"},
           {"engine/import/weld.h", "pagestore/disk.h"},
           {"test/solver/refine_test.cpp", "pagestore/record.h"}})
    EXPECT_EQ(found_in(path, "#include \"" + header + "\"").size(), 1u) << path << " " << header;
}

TEST(Layering, TheViolationNamesFileLineAndHeader) {
  const SourceFile source{
      "solver/gather.cpp",
      "#include \"solver/gather.h\"\n\n  #  include \"pagestore/arena.h\" // x\n"};
  const std::vector<std::string> found = layering_violations({&source, 1});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0], "solver/gather.cpp:3: pagestore/arena.h: solver may not include pagestore");
}

TEST(Layering, IncludesNotRootedAtTheRepositoryAreFound) {
  EXPECT_EQ(found_in("solver/gather.cpp", "#include \"gather.h\"").size(), 1u);
  EXPECT_EQ(found_in("solver/gather.cpp", "#include \"../engine/vec.h\"").size(), 1u);
  EXPECT_EQ(found_in("apps/picture/png.cpp", "#include \"picture/image.h\"").size(), 1u);
}

TEST(Layering, ALibraryOutsideItsFolderIsFound) {
  EXPECT_TRUE(found_in("visibility/occlusion.cpp", "#include <embree3/rtcore.h>").empty());
  EXPECT_EQ(found_in("solver/refine.cpp", "#include <embree3/rtcore.h>").size(), 1u);
  EXPECT_TRUE(found_in("test/apps/picture_test.cpp", "#include <ImfHeader.h>").empty());
  EXPECT_EQ(found_in("test/solver/basis_test.cpp", "#include <ImfHeader.h>").size(), 1u);
  EXPECT_EQ(found_in("engine/geometry.cpp", "#include <boost/crc.hpp>").size(), 1u);
  EXPECT_EQ(found_in("engine/status.cpp", "#include <tbb/parallel_for.h>").size(), 1u);
  EXPECT_EQ(found_in("solver/basis.cpp", "#include <nlohmann/json.hpp>").size(), 1u);
  EXPECT_EQ(found_in("engine/status.cpp", "#include <gtest/gtest.h>").size(), 1u);
}

TEST(Layering, AHeaderThatShowsALibraryIsFound) {
  EXPECT_TRUE(found_in("engine/vec.h", "#include <glm/vec3.hpp>").empty());
  EXPECT_EQ(found_in("engine/geometry.h", "#include <glm/mat3x3.hpp>").size(), 1u);
  EXPECT_EQ(found_in("engine/vec.h", "#include <toml++/toml.h>").size(), 1u);
  EXPECT_EQ(found_in("visibility/occlusion.h", "#include <embree3/rtcore.h>").size(), 1u);
  EXPECT_EQ(found_in("apps/command.h", "#include <CLI/CLI.hpp>").size(), 1u);
}

TEST(Layering, AnUnknownLibraryIsFound) {
  EXPECT_EQ(found_in("engine/geometry.cpp", "#include <Eigen/Dense>").size(), 1u);
  EXPECT_EQ(found_in("engine/geometry.cpp", "#include <zlib.h>").size(), 1u);
  EXPECT_TRUE(found_in("engine/geometry.cpp", "#include <vector>").empty());
}

TEST(Layering, SolverAndVisibilityNeverSeeADisk) {
  EXPECT_EQ(found_in("solver/gather.cpp", "#include <fstream>").size(), 1u);
  EXPECT_EQ(found_in("visibility/bsp.cpp", "#include <unistd.h>").size(), 1u);
  EXPECT_TRUE(found_in("pagestore/disk.cpp", "#include <unistd.h>").empty());
}

}  // namespace
}  // namespace atrium
