#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"
#include "test/apps/two_rooms.h"

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

TEST(Inspect, SceneHasTheTablesOfItsRun) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj", run_directory = folder / "run";
  ASSERT_EQ(run({"gen", "rooms", "--grid", "2", "-o", scene}).code, 0);
  ASSERT_EQ(run({"solve", scene, "-o", run_directory, "--memory", "64MiB", "--error", "20%"}).code,
            0);
  for (const char* table : {"--cells", "--portals", "--visible"}) {
    ASSERT_EQ(run({"inspect", scene, table, folder / "scene"}).code, 0) << table;
    ASSERT_EQ(run({"inspect", run_directory, table, folder / "run-table"}).code, 0) << table;
    EXPECT_FALSE(read_file(folder / "scene").empty());
    EXPECT_EQ(read_file(folder / "scene"), read_file(folder / "run-table")) << table;
  }
}

TEST(Inspect, LeaksNameAPlantedGapAndNoneWithoutIt) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj";
  write_file(scene, two_rooms_obj(1));
  const Ended e = run({"inspect", scene, "--unit", "cm", "--leaks", "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json leaks = Json::parse(e.out)["leaks"];
  ASSERT_EQ(leaks.size(), 1u);
  constexpr double kGap = 0.01, kLong = 4, kShare = 0.01;  // m; relative
  EXPECT_NEAR(leaks[0]["width"].get<double>(), kGap, kShare * kGap);
  EXPECT_NEAR(leaks[0]["length"].get<double>(), kLong, kShare * kLong);
  EXPECT_EQ(leaks[0]["rooms"], Json({0, 1}));
  EXPECT_NEAR(leaks[0]["at"][2].get<double>(), 299.5, 0.1);  // cm: the middle of the gap
  const auto objects = leaks[0]["objects"].get<std::set<std::string>>();
  EXPECT_TRUE(objects.contains("partition") && objects.contains("ceiling"));

  ASSERT_EQ(run({"inspect", scene, "--unit", "cm", "--leaks-csv", folder / "leaks.csv"}).code, 0);
  const std::string csv = read_file(folder / "leaks.csv");
  EXPECT_EQ(csv.rfind("width,length,room_a,room_b,x,y,z,", 0), 0u);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 2);

  const Ended smaller = run({"inspect", scene, "--unit", "cm", "--leaks", "--leak-size", "9mm"});
  EXPECT_NE(smaller.out.find("lead outdoors: 0"), std::string::npos) << smaller.out;
  write_file(scene, two_rooms_obj(0));
  const Ended closed = run({"inspect", scene, "--unit", "cm", "--leaks", "--json"});
  EXPECT_EQ(Json::parse(closed.out)["leaks"].size(), 0u);
  EXPECT_EQ(run({"inspect", scene, "--leaks", "--leak-size", "0"}).code, 2);
}

TEST(Inspect, FloorPlanNumbersTheRoomsItCuts) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj", plan = folder / "plan.svg";
  write_file(scene, two_rooms_obj(0));
  ASSERT_EQ(run({"inspect", scene, "--unit", "cm", "--floor-plan", plan}).code, 0);
  const std::string svg = read_file(plan);
  EXPECT_EQ(svg.rfind("<svg ", 0), 0u);
  for (const char* label : {">0</text>", ">1</text>"})
    EXPECT_NE(svg.find(label), std::string::npos) << label;
  EXPECT_EQ(svg.find(">2</text>"), std::string::npos);
  // Above the roof there is nothing to number.
  ASSERT_EQ(run({"inspect", scene, "--unit", "cm", "--floor-plan", plan, "--height", "9m"}).code,
            0);
  EXPECT_EQ(read_file(plan).find(">0</text>"), std::string::npos);
  EXPECT_EQ(run({"inspect", scene, "--unit", "cm", "--floor-plan", plan, "--storey", "9"}).code, 2);
}

TEST(Inspect, LeaksOfARunAreThoseOfItsScene) {
  const Ended e = run({"inspect", furnace_run(), "--leaks", "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  EXPECT_EQ(Json::parse(e.out)["leaks"].size(), 0u);
}

}  // namespace
}  // namespace atrium::testing
