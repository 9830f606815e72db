// --close-gaps from outside, on two rooms with 3 mm between their partition and the ceiling and a
// lamp in the first.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "test/apps/program.h"
#include "test/apps/two_rooms.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

constexpr double kGap = 0.003, kLong = 4, kShare = 0.05;  // m; relative
constexpr int kBoxVertices = 7 * 8;                       // of the two rooms

// The scene's path; it is in centimetres.
std::string lit_rooms(const Folder& folder) {
  std::ostringstream obj;
  obj << "mtllib lamp.mtl\n"
      << two_rooms_obj(100 * kGap) << "o lamp\nusemtl lamp\n"
      << "v 150 150 290\nv 150 250 290\nv 250 250 290\nv 250 150 290\nf";
  for (int i = 1; i <= 4; ++i) obj << ' ' << kBoxVertices + i;
  write_file(folder / "lamp.mtl", "newmtl lamp\nKd 0.5 0.5 0.5\nKe 100 100 100\n");
  write_file(folder / "rooms.obj", obj.str() + "\n");
  return folder / "rooms.obj";
}

Json planned(const std::string& scene, const std::string& gap) {
  const Ended e = run({"plan", scene, "--unit", "cm", "--close-gaps", gap, "--json"});
  EXPECT_EQ(e.code, 0) << e.err;
  return Json::parse(e.out);
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(CloseGaps, PlanNamesWhatItCloses) {
  const Folder folder;
  const std::string scene = lit_rooms(folder);
  const Json strict = planned(scene, "0"), narrower = planned(scene, "2mm"),
             closed = planned(scene, "4mm");
  EXPECT_EQ(strict["closed_gaps"], Json::array());
  EXPECT_EQ(narrower, strict);
  EXPECT_LT(closed["clusters"], strict["clusters"]);  // the second room is dark
  ASSERT_EQ(closed["closed_gaps"].size(), 1u);
  const Json& gap = closed["closed_gaps"][0];
  EXPECT_NEAR(gap["width"].get<double>(), kGap, kShare * kGap);
  EXPECT_NEAR(gap["length"].get<double>(), kLong, kShare * kLong);
  EXPECT_NEAR(gap["at"][0].get<double>(), 400, 0.1);  // cm: the partition's face to the lamp
  const auto objects = gap["objects"].get<std::set<std::string>>();
  EXPECT_TRUE(objects.contains("partition") && objects.contains("ceiling"));
  const Ended told = run({"plan", scene, "--unit", "cm", "--close-gaps", "4mm"});
  EXPECT_EQ(count_of(told.out, "closed gap      "), 1u) << told.out;
  EXPECT_NE(told.out.find("closed 1 gap up to 2.99"), std::string::npos) << told.out;
}

TEST(CloseGaps, WhatIsNoLengthIsRefused) {
  for (const char* length : {"-1mm", "wide", "4mm2", ""})
    EXPECT_EQ(run({"plan", "rooms.obj", "--close-gaps", length}).code, 2) << length;
}

TEST(CloseGaps, ValidateTellsWhatIsExempt) {
  const Folder folder;
  const std::string scene = lit_rooms(folder);
  for (const std::string gap : {"0", "4mm"}) {
    const Ended e = run({"validate", "visibility", scene, "--unit", "cm", "--segments", "50000",
                         "--close-gaps", gap, "--json"});
    ASSERT_EQ(e.code, 0) << e.err << e.out;
    const Json found = Json::parse(e.out);
    EXPECT_EQ(found["closed_gaps"], gap == "0" ? 0 : 1);
    EXPECT_TRUE(found.contains("exempt_through_closed_gaps"));
  }
}

TEST(CloseGaps, TablesOfASceneAreThoseOfTheRunWithItsGapsClosed) {
  const Folder folder;
  const std::string scene = lit_rooms(folder), run_directory = folder / "run";
  const std::vector<std::string> solve{"solve", scene,     "-o",  run_directory,  "--unit",
                                       "cm",    "--error", "20%", "--iterations", "1"};
  std::vector<std::string> closing = solve;
  closing.insert(closing.end(), {"--close-gaps", "4mm"});
  const Ended solved = run(closing);
  ASSERT_EQ(solved.code, 5) << solved.err;
  EXPECT_NE(solved.err.find("warning: closed 1 gap up to 2.99"), std::string::npos) << solved.err;
  EXPECT_EQ(run(solve).code, 2);  // another run

  ASSERT_EQ(run({"resume", run_directory}).code, 5);
  EXPECT_EQ(count_of(read_file(run_directory + "/run.log"), "closed gap: "), 1u);
  for (const char* table : {"--cells", "--portals", "--visible"}) {
    ASSERT_EQ(
        run({"inspect", scene, "--unit", "cm", "--close-gaps", "4mm", table, folder / "closed"})
            .code,
        0);
    ASSERT_EQ(run({"inspect", scene, "--unit", "cm", table, folder / "strict"}).code, 0);
    ASSERT_EQ(run({"inspect", run_directory, table, folder / "of-run"}).code, 0);
    EXPECT_EQ(read_file(folder / "closed"), read_file(folder / "of-run")) << table;
    EXPECT_NE(read_file(folder / "strict"), read_file(folder / "of-run")) << table;
  }
}

}  // namespace
}  // namespace atrium::testing
