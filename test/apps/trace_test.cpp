// `atrium trace` from outside, on traces small enough to count by hand.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

// 1 2 1 3 2 1, all of 10 bytes, 1 written by its second request.
constexpr const char* kCsv =
    "time,id,size,op\n0,1,10,get\n0,2,10,get\n1,1,10,put\n1,3,10,get\n2,2,10,get\n2,1,10,get\n";

class TraceCommand : public ::testing::Test {
 protected:
  TraceCommand() { write_file(csv_, kCsv); }
  // The JSON of a run that must succeed; messages must go to stderr.
  static Json json(std::vector<std::string> words) {
    words.push_back("--json");
    const Ended e = run(words);
    EXPECT_EQ(e.code, 0) << e.err;
    return Json::parse(e.out, nullptr, false);
  }
  std::string atr() const {
    const std::string path = folder_ / "t.atr";
    EXPECT_EQ(run({"trace", "convert", csv_, path}).code, 0);
    return path;
  }

  Folder folder_;
  const std::string csv_ = folder_ / "t.csv";
};

TEST_F(TraceCommand, InfoCountsWhatIsThere) {
  const Json info = json({"trace", "info", csv_});
  EXPECT_EQ(info["format"], "csv");
  EXPECT_EQ(info["requests"], 6);
  EXPECT_EQ(info["records"], 3);
  EXPECT_EQ(info["bytes"], 60);
  EXPECT_EQ(info["unique_bytes"], 30);
  EXPECT_EQ(info["dirties"], 1);
  EXPECT_EQ(info["smallest_arena"], 10);
  const Json ours = json({"trace", "info", atr()});
  EXPECT_EQ(ours["format"], "atr");
  EXPECT_EQ(ours["pins"], true);
  EXPECT_EQ(ours["requests"], 6);
  EXPECT_EQ(ours["unique_bytes"], 30);
  EXPECT_EQ(ours["smallest_arena"], 4096);  // one granule
  const Ended text = run({"trace", "info", csv_});
  EXPECT_NE(text.out.find("unique_bytes"), std::string::npos);
}

TEST_F(TraceCommand, InfoKnowsGrowth) {
  // 5 is 100 bytes long, then 250.
  write_file(csv_, "time,id,size,op\n0,5,100,put\n0,5,250,put\n0,6,9,get\n");
  const Json info = json({"trace", "info", atr()});
  EXPECT_EQ(info["grown_records"], 1);
  EXPECT_EQ(info["growth"], 150);
  EXPECT_EQ(info["unique_bytes"], 259);
  EXPECT_EQ(info["bytes"], 100 + 250 + 9 - 150);  // a read finds what was there before
}

TEST_F(TraceCommand, ConvertThereAndBackGivesTheSameBytes) {
  const Ended out = run({"trace", "convert", atr(), folder_ / "back.csv"});
  EXPECT_EQ(out.code, 0) << out.err;
  EXPECT_NE(out.err.find("how long records are pinned"), std::string::npos);
  // Without its times, which are numbers of gathers now: none began.
  EXPECT_EQ(read_file(folder_ / "back.csv"),
            "time,id,size,op\n0,1,10,get\n0,2,10,get\n0,1,10,put\n0,3,10,get\n0,2,10,get\n"
            "0,1,10,get\n");
  const std::string oracle = folder_ / "t.bin", again = folder_ / "again.csv";
  const Json made = json({"trace", "convert", csv_, oracle});
  EXPECT_EQ(made["lost"], Json({"1 changes of records"}));
  EXPECT_EQ(read_file(oracle).size(), 6u * 24u);
  EXPECT_EQ(run({"trace", "convert", oracle, again}).code, 0);
  std::string gets = kCsv;
  gets.replace(gets.find("put"), 3, "get");
  EXPECT_EQ(read_file(again), gets);
}

TEST_F(TraceCommand, ConvertTakesColumnsAndAFormat) {
  write_file(csv_, "version,time,op,size,lbn\n1,0,2a,512,7\n");
  const std::string out = folder_ / "out";
  EXPECT_EQ(run({"trace", "convert", csv_, out}).code, 2);  // no ending
  const Ended e =
      run({"trace", "convert", csv_, out, "--to", "csv", "--columns", "time=2,op=3,size=4,id=5"});
  EXPECT_EQ(e.code, 0) << e.err;
  EXPECT_EQ(read_file(out), "time,id,size,op\n0,7,512,put\n");
  EXPECT_EQ(run({"trace", "convert", csv_, csv_}).code, 2);  // onto itself
  EXPECT_EQ(read_file(csv_), "version,time,op,size,lbn\n1,0,2a,512,7\n");
}

TEST_F(TraceCommand, SimulateCountsByPolicyAndArena) {
  // LRU with room for two: 1 miss, 2 miss, 1 hit and dirty, 3 miss (2 leaves), 2 miss (1 leaves and
  // is written), 1 miss (3 leaves). With room for all: three misses, 1 dirty at the end.
  const Json r = json({"trace", "simulate", csv_, "--policy", "lru,fifo", "--arena", "20,1.0"});
  ASSERT_EQ(r["rows"].size(), 4u);
  const Json& two = r["rows"][0];
  EXPECT_EQ(two["policy"], "lru");
  EXPECT_EQ(two["arena"], 20);
  EXPECT_EQ(two["requests"], 6);
  EXPECT_EQ(two["hits"], 1);
  EXPECT_EQ(two["misses"], 5);
  EXPECT_EQ(two["miss_bytes"], 50);
  EXPECT_EQ(two["evictions"], 3);
  EXPECT_EQ(two["writebacks"], 1);
  EXPECT_EQ(two["writeback_bytes"], 10);
  EXPECT_EQ(two["final_flush"], 0);
  EXPECT_TRUE(two.contains("min_feasible_arena"));
  EXPECT_GT(two["seconds"], 0);
  const Json& all = r["rows"][1];
  EXPECT_EQ(all["arena"], 30);  // all of it
  EXPECT_EQ(all["misses"], 3);
  EXPECT_EQ(all["final_flush"], 1);
  EXPECT_EQ(r["rows"][2]["policy"], "fifo");
  // A bound an arena, in the order of the arenas; three records have to come in, whatever the
  // policy.
  ASSERT_EQ(r["lower_bound_misses"].size(), 2u);
  EXPECT_NEAR(r["lower_bound_misses"][1].get<double>(), 3, 1e-6);
  for (const Json& row : r["rows"])
    EXPECT_GE(row["misses"], r["lower_bound_misses"][row["arena"] == 30]);
}

TEST_F(TraceCommand, SimulateInUnitsTakesNumbersAndSharesOfRecords) {
  const Json r =
      json({"trace", "simulate", csv_, "--arena", "2,0.7,100%", "--unit-size", "--bound", "off"});
  EXPECT_EQ(r["rows"][0]["misses"], 5);
  EXPECT_EQ(r["rows"][1]["arena"], 2);  // 0.7 of three records, rounded down
  EXPECT_EQ(r["rows"][1]["misses"], 5);
  EXPECT_EQ(r["rows"][2]["misses"], 3);
  EXPECT_TRUE(r["lower_bound_misses"][0].is_null());
  EXPECT_EQ(run({"trace", "simulate", csv_, "--arena", "2KiB", "--unit-size"}).code, 2);
}

TEST_F(TraceCommand, SimulateModelsTheDisk) {
  // Five reads and one write of ten bytes, a second each and ten bytes a second.
  const Json r = json({"trace", "simulate", csv_, "--arena", "20", "--seconds-per-read", "1s",
                       "--bandwidth", "10B/s"});
  EXPECT_NEAR(r["rows"][0]["seconds"].get<double>(), 6 * (1 + 1), 1e-9);
}

TEST_F(TraceCommand, ArenasThatCannotHoldWhatIsPinnedAreRefused) {
  const std::string trace = atr();
  const Ended one = run({"trace", "simulate", trace, "--arena", "100,4096", "--json"});
  EXPECT_EQ(one.code, 0);
  const Json rows = Json::parse(one.out)["rows"];
  EXPECT_TRUE(rows[0]["misses"].is_null());
  EXPECT_EQ(rows[0]["min_feasible_arena"], 4096);
  EXPECT_EQ(rows[1]["misses"], 6);  // room for one; no two requests in a row are for the same
  EXPECT_NE(one.err.find("4096"), std::string::npos);
  const Ended none = run({"trace", "simulate", trace, "--arena", "100", "--json"});
  EXPECT_EQ(none.code, 2);
  EXPECT_NE(none.err.find("4096"), std::string::npos);
}

TEST_F(TraceCommand, SimulateForPeople) {
  const Ended e = run({"trace", "simulate", csv_, "--arena", "20"});
  EXPECT_EQ(e.code, 0);
  EXPECT_NE(e.out.find("83.33%"), std::string::npos) << e.out;  // 5 of 6
}

TEST_F(TraceCommand, CurveHasTheSimulatedMisses) {
  const std::string out = folder_ / "curve.csv";
  EXPECT_EQ(run({"trace", "curve", csv_, "-o", out}).code, 0);
  EXPECT_EQ(read_file(out).find("arena,misses,miss_ratio,miss_bytes,writebacks"), 0u);
  const Json curve = json({"trace", "curve", csv_});
  EXPECT_EQ(curve["policy"], "lru");
  EXPECT_EQ(curve["requests"], 6);
  EXPECT_EQ(curve["smallest_arena"], 10);
  ASSERT_FALSE(curve["points"].empty());
  // The last point holds for every larger arena: each record comes in once.
  EXPECT_EQ(curve["points"].back()["misses"], 3);
  EXPECT_EQ(run({"trace", "curve", csv_, "--policy", "lru,fifo"}).code, 2);
  EXPECT_EQ(run({"trace", "curve", csv_, "--sample", "0"}).code, 2);
}

TEST_F(TraceCommand, ReplayCountsAsTheSimulationDoes) {
  const Json r = json({"trace", "replay", atr(), "--store", folder_ / "store", "--arena", "8192"});
  EXPECT_EQ(r["differ"], Json::array());
  EXPECT_EQ(r["replayed"]["misses"], 5);  // as simulated above: two records of a granule each
  EXPECT_EQ(r["simulated"]["misses"], 5);
  EXPECT_EQ(r["replayed"]["writebacks"], 1);
  const Ended text =
      run({"trace", "replay", atr(), "--store", folder_ / "store2", "--arena", "8192"});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("simulated"), std::string::npos);
  EXPECT_EQ(run({"trace", "replay", atr(), "--arena", "8192"}).code, 2);  // nowhere
}

TEST_F(TraceCommand, ACutFileIsReadAndSaidToBe) {
  const std::string trace = atr(), whole = read_file(trace);
  write_file(trace, whole.substr(0, whole.size() - 1));
  const Ended e = run({"trace", "info", trace, "--json"});
  EXPECT_EQ(e.code, 0);
  EXPECT_NE(e.err.find("left over"), std::string::npos);
  const Json info = Json::parse(e.out);
  EXPECT_EQ(info["complete"], false);
  EXPECT_EQ(info["left_over"], 23);  // of the empty chunk at the end
  EXPECT_EQ(info["requests"], 6);
}

TEST_F(TraceCommand, WrongWordsAreRefused) {
  EXPECT_EQ(run({"trace"}).code, 2);
  EXPECT_EQ(run({"trace", "info"}).code, 2);
  EXPECT_EQ(run({"trace", "paint", csv_}).code, 2);
  EXPECT_EQ(run({"trace", "convert", csv_}).code, 2);
  EXPECT_EQ(run({"trace", "info", csv_, csv_}).code, 2);
  EXPECT_EQ(run({"trace", "info", folder_ / "missing.csv"}).code, 2);
  EXPECT_EQ(run({"trace", "simulate", csv_}).code, 2);
  for (const std::string arena : {"0", "-1", "1.5", "200%", "1MiB,", "many", "0.0001"})
    EXPECT_EQ(run({"trace", "simulate", csv_, "--arena", arena}).code, 2) << arena;
  const Ended policy = run({"trace", "simulate", csv_, "--arena", "20", "--policy", "lru,luck"});
  EXPECT_EQ(policy.code, 2);
  EXPECT_NE(policy.err.find("luck"), std::string::npos);
  EXPECT_EQ(run({"trace", "simulate", csv_, "--arena", "20", "--reorder", "model"}).code, 2);
  EXPECT_EQ(run({"trace", "simulate", csv_, "--arena", "20", "--bandwidth", "0B/s"}).code, 2);
  write_file(folder_ / "bad.atr", "ATRTRACE and then nothing of sense");
  EXPECT_EQ(run({"trace", "info", folder_ / "bad.atr"}).code, 4);
}

// The public trace of ../shared against libCacheSim's numbers for it.
TEST(TraceCommandShared, CloudphysicsIsCountedAsLibCacheSimCountsIt) {
  const std::string trace =
      std::string(ATRIUM_SHARED_DIR) + "/traces/cloudphysics.oracleGeneral.bin";
  if (!std::filesystem::exists(trace)) GTEST_SKIP() << trace << " is missing";
  const Ended info = run({"trace", "info", trace, "--json"});
  EXPECT_EQ(Json::parse(info.out)["requests"], 113872);
  EXPECT_EQ(Json::parse(info.out)["records"], 48974);
  EXPECT_EQ(Json::parse(info.out)["unique_bytes"], 2029769728);
  const Ended e = run({"trace", "simulate", trace, "--policy", "lru,fifo", "--arena",
                       "128MiB,512MiB", "--bound", "off", "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json rows = Json::parse(e.out)["rows"];
  const std::vector<int> misses{93374, 81722, 93403, 84025};
  for (std::size_t i = 0; i < misses.size(); ++i) EXPECT_EQ(rows[i]["misses"], misses[i]);
}

}  // namespace
}  // namespace atrium::testing
