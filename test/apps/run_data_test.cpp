#include "apps/report/run_data.h"

#include <gtest/gtest.h>

#include "apps/report/option_table.h"
#include "scheduler/history.h"
#include "test/apps/program.h"

namespace atrium::testing {
namespace {

constexpr const char* kPath = "run/history.jsonl";

// A line of an iteration that has reached so many clusters.
std::string line(int iteration, int gathered, double seconds, const std::string& more = "") {
  return "{\"seconds\":" + std::to_string(seconds) + ",\"iteration\":" + std::to_string(iteration) +
         ",\"clusters_gathered\":" + std::to_string(gathered) + more + "}\n";
}

std::vector<double> iterations_of(const std::vector<HistoryEntry>& history) {
  std::vector<double> found;
  for (const HistoryEntry& e : history) found.push_back(*e.iteration);
  return found;
}

using Numbers = std::vector<double>;

TEST(ParseHistory, WhatTheProgramWritesComesBack) {
  HistoryLine written;
  written.seconds = 12.5;
  written.cpu_seconds = 20.25;
  written.iteration = 3;
  written.clusters_gathered = 44;
  written.residual = 0.0625;
  written.error_true = 0.015625;
  written.elements = 9637;
  written.links = 19105;
  written.rays = 28281;
  written.reads = 7;
  written.writes = 8;
  written.bytes_read = 7000;
  written.bytes_written = 8000;
  written.hit_ratio = 0.75;
  written.solver_seconds = 10;
  written.io_seconds = 1;
  written.stall_seconds = 0.5;
  written.max_working_set_bytes = 1 << 20;
  written.peak_rss_bytes = 1 << 30;
  written.working_sets = {{5000, 7000}, {4000, 6000}};
  const auto history = parse_history(history_json(written) + "\n", kPath);
  ASSERT_TRUE(history.ok()) << history.status().message();
  ASSERT_EQ(history->size(), 1u);
  const HistoryEntry& e = history->front();
  EXPECT_EQ(e.seconds, written.seconds);
  EXPECT_EQ(e.cpu_seconds, written.cpu_seconds);
  EXPECT_EQ(e.iteration, 3);
  EXPECT_EQ(e.clusters_gathered, 44);
  EXPECT_EQ(e.residual, written.residual);
  EXPECT_EQ(e.error_true, written.error_true);
  EXPECT_EQ(e.elements, 9637);
  EXPECT_EQ(e.links, 19105);
  EXPECT_EQ(e.rays, 28281);
  EXPECT_EQ(e.reads, 7);
  EXPECT_EQ(e.writes, 8);
  EXPECT_EQ(e.bytes_read, 7000);
  EXPECT_EQ(e.bytes_written, 8000);
  EXPECT_EQ(e.hit_ratio, 0.75);
  EXPECT_EQ(e.solver_seconds, 10);
  EXPECT_EQ(e.io_seconds, 1);
  EXPECT_EQ(e.stall_seconds, 0.5);
  EXPECT_EQ(e.max_working_set_bytes, 1 << 20);
  EXPECT_EQ(e.peak_rss_bytes, 1 << 30);
  EXPECT_EQ(e.largest_working_sets, (Numbers{5000, 7000}));
  EXPECT_EQ(e.mean_working_sets, (Numbers{4000, 6000}));
}

TEST(ParseHistory, WhatIsNullOrNotThereIsNotThere) {
  const auto history = parse_history(line(1, 4, 1, ",\"residual\":null"), kPath);
  ASSERT_TRUE(history.ok());
  EXPECT_FALSE(history->front().residual);
  EXPECT_FALSE(history->front().error_estimate);
  EXPECT_FALSE(history->front().error_true);
}

TEST(ParseHistory, EstimateIntervalAndClosureAreRead) {
  const auto history = parse_history(line(1, 4, 1,
                                          ",\"error_estimate\":0.02,\"error_estimate_low\":-0.001,"
                                          "\"error_estimate_high\":0.03,\"energy_closure\":-0.01"),
                                     kPath);
  ASSERT_TRUE(history.ok()) << history.status().message();
  const HistoryEntry& e = history->front();
  EXPECT_EQ(e.error_estimate, 0.02);
  EXPECT_EQ(e.error_estimate_low, -0.001);
  EXPECT_EQ(e.error_estimate_high, 0.03);
  EXPECT_EQ(e.energy_closure, -0.01);
}

TEST(ParseHistory, ABrokenLineIsNamed) {
  for (const std::string broken :
       {"nonsense", "{\"seconds\":1,", "[1]", "", "{\"seconds\":2}", "{\"iteration\":2}",
        "{\"seconds\":\"2\",\"iteration\":2}", "{\"seconds\":2,\"iteration\":2,\"links\":-1}",
        "{\"seconds\":2,\"iteration\":2,\"links\":true}", "{\"seconds\":1e999,\"iteration\":2}"}) {
    const auto history = parse_history(line(1, 4, 1) + broken + "\n" + line(3, 4, 3), kPath);
    ASSERT_FALSE(history.ok()) << broken;
    EXPECT_EQ(history.status().code(), Code::kStore) << broken;
    EXPECT_EQ(history.status().file(), kPath);
    EXPECT_EQ(history.status().place(), "line 2") << broken;
    EXPECT_FALSE(history.status().cause().empty());
  }
}

TEST(ParseHistory, ALineThatIsBeingWrittenEndsIt) {
  const auto history = parse_history(line(1, 4, 1) + "{\"seconds\":2,\"iter", kPath);
  ASSERT_TRUE(history.ok());
  EXPECT_EQ(history->size(), 1u);
}

// A crash after iteration 3; the checkpoint was in iteration 2, and its clock is taken up.
TEST(ParseHistory, WhatWasDoneAgainAfterACrashCountsOnce) {
  const auto history = parse_history(line(1, 4, 10) + line(2, 4, 20) + line(3, 4, 30) +
                                         line(2, 3, 25) + line(2, 4, 26) + line(3, 4, 33),
                                     kPath);
  ASSERT_TRUE(history.ok());
  EXPECT_EQ(iterations_of(*history), (Numbers{1, 2, 2, 3}));
  EXPECT_EQ((*history)[1].seconds, 25);
  EXPECT_EQ((*history)[3].seconds, 33);
}

TEST(CompleteIterations, AreTheLastLinesOfThoseThatReachedAllClusters) {
  RunData run;
  run.history = *parse_history(
      line(1, 2, 1) + line(1, 4, 2) + line(2, 1, 3) + line(2, 3, 4) + line(2, 4, 5) + line(3, 2, 6),
      kPath);
  EXPECT_EQ(run.history.size(), 6u);
  const std::vector<HistoryEntry> complete = complete_iterations(run);
  EXPECT_EQ(iterations_of(complete), (Numbers{1, 2}));
  EXPECT_EQ(complete[1].seconds, 5);
}

TEST(CompleteIterations, TheSummaryKnowsHowManyClustersThereAre) {
  RunData run;
  run.history = *parse_history(line(1, 2, 1), kPath);
  EXPECT_EQ(complete_iterations(run).size(), 1u);
  run.summary.emplace().clusters = 4;
  EXPECT_TRUE(complete_iterations(run).empty());
}

TEST(ParseSummary, WhatTheProgramWritesComesBack) {
  SolveSummary written;
  written.iterations = 18;
  written.flux_emitted = 14.5;
  written.exit_code = 5;
  written.stop_reason = "time limit";
  written.left_out = {{"rays", "no room has anything in it"}};
  const auto summary = parse_summary(summary_json(written), "summary.json");
  ASSERT_TRUE(summary.ok()) << summary.status().message();
  EXPECT_EQ(summary->iterations, 18);
  EXPECT_EQ(summary->flux_emitted, 14.5);
  EXPECT_EQ(summary->exit_code, 5);
  EXPECT_EQ(summary->stop_reason, "time limit");
  EXPECT_EQ(summary->version, program_version());
  ASSERT_EQ(summary->left_out.size(), 1u);
  EXPECT_EQ(summary->left_out[0].feature, "rays");
  EXPECT_EQ(summary->left_out[0].why, "no room has anything in it");
  EXPECT_FALSE(summary->error_true);
}

TEST(ParseSummary, ABrokenOneIsNamed) {
  const auto cut = parse_summary("{\n \"links\": 3,\n \"elem", "summary.json");
  ASSERT_FALSE(cut.ok());
  EXPECT_EQ(cut.status().code(), Code::kStore);
  EXPECT_EQ(cut.status().place(), "line 3");
  for (const std::string broken :
       {"[]", "{\"links\":\"3\"}", "{\"stop_reason\":3}", "{\"left_out\":3}", "{\"left_out\":[3]}",
        "{\"left_out\":[{\"why\":3}]}", "{\"reads\":-1}"}) {
    const auto summary = parse_summary(broken, "summary.json");
    ASSERT_FALSE(summary.ok()) << broken;
    EXPECT_EQ(summary.status().code(), Code::kStore);
    EXPECT_EQ(summary.status().file(), "summary.json");
  }
}

class ReadRun : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) {
    std::filesystem::create_directories(directory());
    write_file(directory() + "/" + name, text);
  }
  std::string directory() const { return folder_ / "run"; }

 private:
  Folder folder_;
};

TEST_F(ReadRun, WithoutASummaryItWasInterrupted) {
  write("run.toml", run_toml(SolveOptions{}));
  write("history.jsonl", line(1, 4, 1));
  const auto run = read_run(directory());
  ASSERT_TRUE(run.ok()) << run.status().message();
  EXPECT_EQ(run->life, RunLife::kInterrupted);
  EXPECT_EQ(run->history.size(), 1u);
  EXPECT_FALSE(run->summary);
}

TEST_F(ReadRun, ASummaryThatTheHistoryHasOutgrownIsNone) {
  write("run.toml", run_toml(SolveOptions{}));
  write("summary.json", "{\"iterations\":2,\"clusters\":4}");
  write("history.jsonl", line(1, 4, 1) + line(2, 4, 2) + line(3, 3, 3));
  EXPECT_EQ(read_run(directory())->life, RunLife::kEnded) << "stopped within iteration 3";
  write("history.jsonl", line(1, 4, 1) + line(2, 4, 2) + line(3, 3, 3) + line(3, 4, 4));
  const auto run = read_run(directory());
  EXPECT_EQ(run->life, RunLife::kInterrupted);
  EXPECT_FALSE(run->summary);
}

TEST_F(ReadRun, WhatIsNoRunIsAUsageErrorAndABrokenOneIsNot) {
  EXPECT_EQ(read_run(directory()).status().code(), Code::kUsage);
  write("run.toml", "error = \nmemory");
  const auto broken = read_run(directory());
  ASSERT_FALSE(broken.ok());
  EXPECT_EQ(broken.status().code(), Code::kStore);
  EXPECT_EQ(broken.status().file(), directory() + "/run.toml");
  EXPECT_EQ(broken.status().place(), "line 1");
}

RunData run_with(const SolveOptions& options) {
  RunData run;
  run.options = parse_settings(run_toml(options), "run.toml")->settings;
  return run;
}

TEST(TellingOptions, AreThoseThatDifferBetweenRunsOrFromTheirDefaults) {
  SolveOptions a, b;
  a.scene.files = b.scene.files = {"/scenes/room.obj"};
  a.memory = b.memory = 256u << 20;
  b.error = 0.05;
  b.basis = 1;
  const RunData run_a = run_with(a), run_b = run_with(b);
  const std::vector<OptionRow> rows = telling_options({&run_a, &run_b});
  ASSERT_EQ(rows.size(), 3u);
  for (const OptionRow& row : rows) EXPECT_EQ(row.differs, row.key != "memory") << row.key;
  const auto values = [&](const std::string& key) {
    for (const OptionRow& row : rows)
      if (row.key == key) return row.values;
    return std::vector<std::string>{};
  };
  EXPECT_EQ(values("memory"), (std::vector<std::string>{"256 MiB", "256 MiB"}));
  EXPECT_EQ(values("error"), (std::vector<std::string>{"2%", "5%"}));
  EXPECT_EQ(values("basis"), (std::vector<std::string>{std::to_string(a.basis), "1"}));
}

TEST(TellingOptions, WhatOneRunDoesNotHaveIsEmptyThere) {
  SolveOptions a, b;
  b.reference = "/somewhere/else/points.csv";
  const RunData run_a = run_with(a), run_b = run_with(b);
  const std::vector<OptionRow> rows = telling_options({&run_a, &run_b});
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].key, "reference");
  EXPECT_EQ(rows[0].values, (std::vector<std::string>{"", "points.csv"}));
  EXPECT_TRUE(rows[0].differs);
}

}  // namespace
}  // namespace atrium::testing
