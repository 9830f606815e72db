#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

TEST(Validate, VisibilityOfASoundSceneIsATableAndZero) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj";
  ASSERT_EQ(run({"gen", "rooms", "--grid", "2", "-o", scene}).code, 0);
  const Ended e = run({"validate", "visibility", scene, "--segments", "50000"});
  EXPECT_EQ(e.code, 0) << e.err << e.out;
  EXPECT_EQ(e.out.rfind("visibility ", 0), 0u);
  EXPECT_NE(e.out.find("  yes\n"), std::string::npos);
  EXPECT_EQ(e.out.find("  NO\n"), std::string::npos);
}

TEST(Validate, JsonHasCasesAndFiguresAndTheSeedAloneDecides) {
  const Folder folder;
  const std::string scene = folder / "rooms.obj";
  ASSERT_EQ(run({"gen", "rooms", "--grid", "2", "-o", scene}).code, 0);
  const auto judged = [&](const std::string& seed, const std::string& threads) {
    const Ended e = run({"validate", "visibility", scene, "--segments", "50000", "--seed", seed,
                         "--threads", threads, "--json"});
    EXPECT_EQ(e.code, 0) << e.err;
    Json found = Json::parse(e.out);
    for (const char* clock : {"seconds", "partition_seconds"}) {
      EXPECT_GT(found[clock].get<double>(), 0) << clock;
      found.erase(clock);
    }
    return found;
  };
  const Json one = judged("7", "1");
  EXPECT_EQ(one["suite"], "visibility");
  ASSERT_EQ(one["cases"].size(), 4u);
  for (const Json& c : one["cases"]) {
    EXPECT_TRUE(c["case"].is_string());
    EXPECT_EQ(c["expected"], 0);
    EXPECT_EQ(c["found"], 0);
    EXPECT_EQ(c["difference"], 0);
    EXPECT_EQ(c["pass"], true);
  }
  EXPECT_EQ(one["segments"], 50000);
  for (const char* figure : {"joined", "blocked", "pairs_kept", "pairs_witnessed", "cells",
                             "portals", "clusters", "tubes_visible"})
    EXPECT_GT(one[figure].get<double>(), 0) << figure;
  EXPECT_EQ(judged("7", "2"), one);
  EXPECT_NE(judged("8", "2"), one);
}

TEST(Validate, FormFactorsAsATableAndAsJson) {
  const Ended table = run({"validate", "form-factors"});
  EXPECT_EQ(table.code, 0) << table.err << table.out;
  EXPECT_EQ(table.out.rfind("form-factors ", 0), 0u);
  EXPECT_EQ(table.out.find("  NO\n"), std::string::npos);
  const Ended e = run({"validate", "form-factors", "--json"});
  EXPECT_EQ(e.code, 0) << e.err;
  const Json found = Json::parse(e.out);
  EXPECT_EQ(found["suite"], "form-factors");
  EXPECT_EQ(found["pass"], true);
  EXPECT_GT(found["cases"].size(), 30u);
  for (const Json& c : found["cases"])
    EXPECT_LE(std::abs(c["difference"].get<double>()), c["allowed"].get<double>()) << c["case"];
}

TEST(Validate, WhatItCannotJudgeIsRefused) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"validate", "clairvoyance"},
           {"validate", "form-factors", "scene.obj"},
           {"validate", "form-factors", "--basis", "0"},
           {"validate", "visibility"},
           {"validate", "visibility", "scene.obj", "--segments", "0"},
           {"validate", "visibility", "scene.obj", "--segments", "1.5"}}) {
    const Ended e = run(words);
    EXPECT_EQ(e.code, 2) << e.err;
    EXPECT_EQ(e.out, "");
  }
  EXPECT_EQ(run({"validate", "visibility", "no/such/scene.obj"}).code, 3);
}

}  // namespace
}  // namespace atrium::testing
