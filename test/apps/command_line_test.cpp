#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

bool says(const Ended& e, const std::string& text) { return e.err.find(text) != std::string::npos; }

TEST(CommandLine, HelpAndVersionEndWithZero) {
  const Ended help = run({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* command :
       {"gen", "inspect", "plan", "solve", "resume", "status", "stop", "check", "probe", "render",
        "export", "report", "formfactor", "trace", "validate"})
    EXPECT_NE(help.out.find(std::string("  ") + command + " "), std::string::npos) << command;
  const Ended version = run({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out.rfind("atrium ", 0), 0u);
  for (const char* library : {"build:", "Embree 3", "OpenEXR 3", "Boost 1"})
    EXPECT_NE(version.out.find(library), std::string::npos) << library;
  EXPECT_EQ(run({"solve", "--help"}).code, 0);
}

TEST(CommandLine, WhatItDoesNotKnowIsAUsageError) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {},
           {"frobnicate"},
           {"gen"},
           {"gen", "cornell", "--frobnicate"},
           {"gen", "cornell", "surplus"},
           {"gen", "palace"},
           {"gen", "cornell", "--seed"},
           {"gen", "cornell", "--seed", "1", "--seed", "2"},
           {"gen", "cornell", "--rho", "0.5"},
           {"solve", "scene.obj"},
           {"solve", "scene.obj", "-o", "run", "--memory", "-1MiB"},
           {"solve", "scene.obj", "-o", "run", "--memory", "64MiBs"},
           {"solve", "scene.obj", "-o", "run", "--error", "0"},
           {"solve", "scene.obj", "-o", "run", "--error", "nan"},
           {"solve", "scene.obj", "-o", "run", "--order", "sideways"},
           {"solve", "scene.obj", "-o", "run", "--unit", "furlong"},
           {"solve", "scene.obj", "-o", "run", "--threads", "0"},
           {"inspect", "scene.obj", "--white", "1"},
           {"probe", "no-such-run"},
           {"resume", "no-such-run"},
           {"status", "no-such-run"},
           {"stop", "no-such-run"},
           {"check", "no-such-run"},
           {"render", "no-such-run", "-o", "view.jpg"},
           {"export", "no-such-run", "-o", "scene.exr"},
           {"report", "no-such-run"}}) {
    const Ended e = run(words);
    std::string line;
    for (const std::string& w : words) line += w + " ";
    EXPECT_EQ(e.code, 2) << line;
    EXPECT_EQ(e.err.rfind("atrium: ", 0), 0u) << line << e.err;
    EXPECT_EQ(e.out, "") << line;
  }
}

TEST(CommandLine, MissingSceneIsABadScene) {
  const Ended e = run({"inspect", "no/such/scene.obj"});
  EXPECT_EQ(e.code, 3);
  EXPECT_TRUE(says(e, "no/such/scene.obj")) << e.err;
}

TEST(CommandLine, SceneWithoutAnyLightIsABadScene) {
  const Folder folder;
  write_file(folder / "dark.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  const Ended e = run({"solve", folder / "dark.obj", "-o", folder / "run"});
  EXPECT_EQ(e.code, 3);
  EXPECT_TRUE(says(e, "light")) << e.err;
}

TEST(CommandLine, TruncatedGlbIsABadScene) {
  const Folder folder;
  ASSERT_EQ(run({"export", furnace_run(), "-o", folder / "cube.glb"}).code, 0);
  const std::string whole = read_file(folder / "cube.glb");
  ASSERT_EQ(run({"inspect", folder / "cube.glb"}).code, 0);
  write_file(folder / "half.glb", whole.substr(0, whole.size() / 2));
  const Ended e = run({"inspect", folder / "half.glb"});
  EXPECT_EQ(e.code, 3);
  EXPECT_TRUE(says(e, "half.glb")) << e.err;
}

TEST(CommandLine, BudgetTooSmallIsRefusedWithTheSmallestThatWillDo) {
  const Folder folder;
  const std::string scene = folder / "cornell.obj";
  ASSERT_EQ(run({"gen", "cornell", "-o", scene}).code, 0);
  const Ended planned = run({"plan", scene, "--json"});
  ASSERT_EQ(planned.code, 0) << planned.err;
  const auto smallest = Json::parse(planned.out)["smallest_memory"].get<std::uint64_t>();
  const Ended refused =
      run({"solve", scene, "-o", folder / "small", "--memory", std::to_string(smallest - 1)});
  EXPECT_EQ(refused.code, 2);
  EXPECT_TRUE(says(refused, "--memory")) << refused.err;
  const Ended taken = run({"solve", scene, "-o", folder / "enough", "--memory",
                           std::to_string(smallest), "--iterations", "1"});
  EXPECT_NE(taken.code, 2) << taken.err;
}

// Far more work than the second it is given. timeout signals its child and then its own group, so
// that the program hears the one request twice.
TEST(CommandLine, TermEndsASolveWith75AndAValidRun) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj";
  ASSERT_EQ(run({"gen", "rooms", "--grid", "6", "-o", scene}).code, 0);
  const Ended e = run({"solve", scene, "-o", folder / "run", "--error", "0.5%", "--json"},
                      "timeout --preserve-status -s TERM 1");
  EXPECT_EQ(e.code, 75) << e.err;
  EXPECT_EQ(Json::parse(e.out)["exit_code"], 75);
  EXPECT_EQ(run({"inspect", folder / "run", "--json"}).code, 0);
}

// Kd as the generator wrote it.
double reflectance_in(const std::string& mtl) {
  const std::string text = read_file(mtl);
  const std::size_t at = text.find("\nKd ");
  return at == std::string::npos ? -1 : std::stod(text.substr(at + 4));
}

TEST(Settings, FlagGoesBeforeEnvironmentBeforeFile) {
  const Folder folder;
  const std::string scene = folder / "cube.obj", config = folder / "house.toml";
  write_file(config, "[gen]\nrho = 0.125\n");
  const std::vector<std::string> words{"gen", "furnace", "-o", scene, "--config", config};
  ASSERT_EQ(run(words).code, 0);
  EXPECT_EQ(reflectance_in(folder / "cube.mtl"), 0.125);
  ASSERT_EQ(run(words, "ATRIUM_RHO=0.25").code, 0);
  EXPECT_EQ(reflectance_in(folder / "cube.mtl"), 0.25);
  std::vector<std::string> with_flag = words;
  with_flag.insert(with_flag.end(), {"--rho", "0.375"});
  ASSERT_EQ(run(with_flag, "ATRIUM_RHO=0.25").code, 0);
  EXPECT_EQ(reflectance_in(folder / "cube.mtl"), 0.375);
}

TEST(Settings, UnknownKeyIsAnErrorWithItsLine) {
  const Folder folder;
  write_file(folder / "a.toml", "json = true\n\nmemroy = \"64MiB\"\n");
  const Ended e = run({"gen", "cornell", "--config", folder / "a.toml", "-o", folder / "c.obj"});
  EXPECT_EQ(e.code, 2);
  EXPECT_TRUE(says(e, "a.toml: line 3")) << e.err;
  EXPECT_TRUE(says(e, "memroy")) << e.err;
  write_file(folder / "b.toml", "[solve]\nrho = 0.5\n");
  EXPECT_EQ(run({"gen", "cornell", "--config", folder / "b.toml", "-o", folder / "c.obj"}).code, 2);
  write_file(folder / "c.toml", "[solve\n");
  EXPECT_EQ(run({"gen", "cornell", "--config", folder / "c.toml", "-o", folder / "c.obj"}).code, 2);
}

TEST(Settings, KeysOfOtherCommandsAreLeftToThem) {
  const Folder folder;
  write_file(folder / "a.toml", "memory = \"64MiB\"\nthreads = 1\n[solve]\nerror = \"5%\"\n");
  EXPECT_EQ(run({"gen", "cornell", "--config", folder / "a.toml", "-o", folder / "c.obj"}).code, 0);
}

TEST(Settings, GlobalFlagsStandBeforeOrAfterTheCommand) {
  const std::string square = "0 0 0;1 0 0;1 1 0;0 1 0", above = "0 0 1;0 1 1;1 1 1;1 0 1";
  const Ended before = run({"--json", "formfactor", square, above});
  const Ended after = run({"formfactor", square, above, "--json"});
  EXPECT_EQ(before.code, 0);
  EXPECT_EQ(before.out, after.out);
  EXPECT_TRUE(Json::accept(before.out));
}

TEST(Settings, QuietSaysNothingAndTheLogKeepsIt) {
  const Folder folder;
  const Ended e = run({"gen", "cornell", "-o", folder / "c.obj", "-q", "--log", folder / "log"});
  EXPECT_EQ(e.code, 0);
  EXPECT_EQ(e.err, "");
  EXPECT_NE(read_file(folder / "log").find("clusters"), std::string::npos);
}

TEST(Output, AFolderThatIsNotThereIsAnErrorOfTheDisk) {
  const Ended e = run({"export", furnace_run(), "-o", "no/such/folder/cube.csv"});
  EXPECT_EQ(e.code, 4);
  EXPECT_TRUE(says(e, "no/such/folder/cube.csv")) << e.err;
}

}  // namespace
}  // namespace atrium::testing
