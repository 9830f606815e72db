#include <gtest/gtest.h>

#include <numbers>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

constexpr double kArea = 6 * kFurnaceSide * kFurnaceSide;  // m²
constexpr double kLumens = 100 * kArea;                    // M · area
constexpr double kRounding = 1e-12;                        // relative

TEST(Inspect, SceneAsJsonHasTheInterfacesFields) {
  const Folder folder;
  const std::string scene = folder / "cube.obj";
  ASSERT_EQ(run({"gen", "furnace", "--rho", "0.5", "--emit", "100", "-o", scene}).code, 0);
  const Ended e = run({"inspect", scene, "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json r = Json::parse(e.out);
  EXPECT_EQ(r["files"], Json({scene}));
  EXPECT_EQ(r["polygons"], 6);
  EXPECT_EQ(r["patches"], 6);
  EXPECT_EQ(r["lights"], 6);
  EXPECT_GE(r["clusters"].get<int>(), 1);
  EXPECT_TRUE(r.contains("bounds"));
  EXPECT_TRUE(r["warnings"].is_array());
  EXPECT_NEAR(r["area"].get<double>(), kArea, kRounding * kArea);
  EXPECT_NEAR(r["lumens"].get<double>(), kLumens, kRounding * kLumens);
  ASSERT_EQ(r["materials"].size(), 1u);
  EXPECT_EQ(r["materials"][0]["reflectance"], Json({0.5, 0.5, 0.5}));
  EXPECT_EQ(r["materials"][0]["faces"], 6);
}

TEST(Inspect, OptionsAreThoseOfSolve) {
  const Folder folder;
  const std::string scene = folder / "cube.obj";
  ASSERT_EQ(run({"gen", "furnace", "--emit", "100", "-o", scene}).code, 0);
  const Ended inches = run({"inspect", scene, "--unit", "in", "--json"});
  ASSERT_EQ(inches.code, 0) << inches.err;
  EXPECT_NEAR(Json::parse(inches.out)["area"].get<double>(), kArea * 0.0254 * 0.0254,
              kRounding * kArea);
  const Ended exitance = run({"inspect", scene, "--emission", "exitance", "--json"});
  EXPECT_NEAR(Json::parse(exitance.out)["lumens"].get<double>(), kLumens / std::numbers::pi,
              kRounding * kLumens);
  EXPECT_EQ(run({"inspect", scene, "--drop", "."}).code, 3);  // nothing is left
}

TEST(Inspect, RunHasTheSummarysFieldsAndItsTables) {
  const Folder folder;
  const Ended e = run({"inspect", furnace_run(), "--json", "--visible", folder / "pairs.csv",
                       "--cells", folder / "cells.csv", "--portals", folder / "portals.obj"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json summary = Json::parse(e.out);
  for (const char* field : {"clusters", "elements", "links", "stop_reason", "exit_code"})
    EXPECT_TRUE(summary.contains(field)) << field;
  // Every wall of a cube sees every other: all pairs, both orders of each.
  std::istringstream lines(read_file(folder / "pairs.csv"));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "receiver,source");
  std::set<std::pair<int, int>> pairs;
  while (std::getline(lines, line)) {
    const std::size_t comma = line.find(',');
    EXPECT_TRUE(pairs.insert({std::stoi(line), std::stoi(line.substr(comma + 1))}).second);
  }
  const int clusters = summary["clusters"].get<int>();
  for (int a = 0; a < clusters; ++a)
    for (int b = 0; b < clusters; ++b)
      EXPECT_TRUE(a == b || pairs.contains({a, b})) << a << "," << b;
  EXPECT_EQ(read_file(folder / "cells.csv").rfind("cell,room,lit,", 0), 0u);
  EXPECT_TRUE(std::filesystem::exists(folder / "portals.obj"));
}

}  // namespace
}  // namespace atrium::testing
