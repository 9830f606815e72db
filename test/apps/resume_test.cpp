#include <gtest/gtest.h>

#include <signal.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <thread>

#include "pagestore/disk.h"
#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kSlot = 4096;   // bytes of a root
constexpr std::size_t kEpochAt = 32;  // in a root
constexpr std::chrono::milliseconds kLook{5};
constexpr std::chrono::seconds kPatience{30};

bool says(const Ended& e, const std::string& text) { return e.err.find(text) != std::string::npos; }

std::vector<std::string> small_solve(const Folder& folder, const std::string& name) {
  return {"solve", folder / "cornell.obj", "-o", folder / name, "--error", "20%"};
}

std::string csv_of(const std::string& run_directory, const Folder& folder) {
  const Ended e = run({"export", run_directory, "-o", folder / "solution.csv"});
  return e.code == 0 ? read_file(folder / "solution.csv") : "none: " + e.err;
}

// Turns a bit in the middle of the newest root.
void damage_newest_root(const std::string& run_directory) {
  std::string roots = read_file(run_directory + "/roots");
  std::uint64_t epochs[2];
  for (std::size_t i : {0, 1}) std::memcpy(&epochs[i], &roots[i * kSlot + kEpochAt], 8);
  roots[(epochs[1] > epochs[0] ? kSlot : 0) + kSlot / 2] ^= 1;
  write_file(run_directory + "/roots", roots);
}

bool wait_until(const std::function<bool()>& done) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kLook);
  }
  return true;
}

// A solve of far more than any test waits for, in a thread of its own.
class LongSolve {
 public:
  explicit LongSolve(const Folder& folder) : directory_(folder / "long") {
    const std::string scene = folder / "rooms.obj";
    EXPECT_EQ(run({"gen", "rooms", "--grid", "6", "-o", scene}).code, 0);
    thread_ = std::thread([this, scene] {
      ended_ =
          run({"solve", scene, "-o", directory_, "--error", "0.5%", "--checkpoint-every", "20ms"});
    });
  }
  ~LongSolve() { end(); }
  LongSolve(const LongSolve&) = delete;
  LongSolve& operator=(const LongSolve&) = delete;

  const std::string& directory() const { return directory_; }
  std::string state() const {
    const Ended e = run({"status", directory_, "--json"});
    return e.code == 0 ? Json::parse(e.out)["state"].get<std::string>() : "";
  }
  void kill_it() {
    if (const auto process = lock_holder(directory_ + "/lock"))
      ::kill(static_cast<pid_t>(*process), SIGKILL);
    end();
  }
  const Ended& end() {
    if (thread_.joinable()) thread_.join();
    return ended_;
  }

 private:
  std::string directory_;
  Ended ended_;
  std::thread thread_;
};

TEST(Resume, DamagedNewestRootStopsTheOthersAndGoesOnFromTheOlder) {
  const Folder folder;
  ASSERT_EQ(run({"gen", "cornell", "-o", folder / "cornell.obj"}).code, 0);
  ASSERT_EQ(run(small_solve(folder, "run")).code, 0);
  // Ended twice: the older root is not the one that knew the first summary.
  ASSERT_EQ(run({"resume", folder / "run"}).code, 0);
  const std::string whole = csv_of(folder / "run", folder);
  damage_newest_root(folder / "run");
  write_file(folder / "points.csv", "0.5,0.5,0.5,0,0,1\n");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"check", folder / "run"},
                                             {"probe", folder / "run", folder / "points.csv"},
                                             {"export", folder / "run", "-o", folder / "x.csv"},
                                             small_solve(folder, "run")}) {
    const Ended e = run(words);
    EXPECT_EQ(e.code, 4) << words[0] << e.err;
    EXPECT_TRUE(says(e, folder / "run/roots: root slot ")) << e.err;
  }
  const Ended resumed = run({"resume", folder / "run"});
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_TRUE(says(resumed, "warning: " + (folder / "run/roots: root slot "))) << resumed.err;
  EXPECT_TRUE(says(resumed, "went on from the root of epoch ")) << resumed.err;
  EXPECT_TRUE(says(resumed, "resumed after ")) << resumed.err;
  EXPECT_EQ(csv_of(folder / "run", folder), whole);
  EXPECT_EQ(run({"check", folder / "run"}).code, 0);
}

TEST(Resume, WhatIsNoRunOrNoLongerItsOwnIsRefused) {
  const Folder folder;
  EXPECT_EQ(run({"resume", folder / "none"}).code, 2);
  std::filesystem::create_directory(folder / "empty");
  EXPECT_EQ(run({"resume", folder / "empty"}).code, 4);
  ASSERT_EQ(run({"gen", "cornell", "-o", folder / "cornell.obj"}).code, 0);
  ASSERT_EQ(run(small_solve(folder, "run")).code, 0);
  EXPECT_EQ(run({"resume", folder / "run", "--threads", "1"}).code, 2);
  const std::string toml = folder / "run/run.toml", text = read_file(toml);
  std::string other = text;
  other.replace(other.find("0.20"), 4, "0.30");
  for (const std::string& damaged : {std::string("scene = ["), std::string(), other}) {
    write_file(toml, damaged);
    const Ended e = run({"resume", folder / "run"});
    EXPECT_EQ(e.code, 4) << damaged;
    EXPECT_TRUE(says(e, toml)) << e.err;
  }
  write_file(toml, text);
  EXPECT_EQ(run({"resume", folder / "run"}).code, 0);
}

TEST(Resume, OptionsComeFromTheRunAndJsonIsItsSummary) {
  const Folder folder;
  ASSERT_EQ(run({"gen", "cornell", "-o", folder / "cornell.obj"}).code, 0);
  auto words = small_solve(folder, "run");
  words.insert(words.end(),
               {"--iterations", "1", "--threads", "1", "--seed", "7", "--order", "random"});
  ASSERT_EQ(run(words).code, 5);
  const Ended e = run({"resume", folder / "run", "--json"});
  EXPECT_EQ(e.code, 5) << e.err;
  const Json summary = Json::parse(e.out);
  EXPECT_EQ(summary["threads"], 1);
  EXPECT_EQ(summary["iterations"], 1);
  EXPECT_EQ(summary["resumes"], 1);
}

TEST(Stop, LiveRunStopsWithACheckpointAndCanBeCheckedBefore) {
  const Folder folder;
  LongSolve solve(folder);
  ASSERT_TRUE(wait_until([&] { return solve.state() == "solving"; }));
  for (int i = 0; i < 5; ++i) {
    const Ended e = run({"check", solve.directory()});
    EXPECT_EQ(e.code, 0) << e.err;
  }
  const Json status = Json::parse(run({"status", solve.directory(), "--json"}).out);
  EXPECT_EQ(status["process"], *lock_holder(solve.directory() + "/lock"));
  EXPECT_GT(status["clusters"], 0);
  EXPECT_TRUE(status["exit_code"].is_null());
  const Ended stopped = run({"stop", solve.directory()});
  EXPECT_EQ(stopped.code, 0) << stopped.err;
  EXPECT_TRUE(says(stopped, "stopped with a checkpoint")) << stopped.err;
  EXPECT_FALSE(lock_holder(solve.directory() + "/lock"));
  EXPECT_EQ(solve.end().code, 75);
  const Json after = Json::parse(run({"status", solve.directory(), "--json"}).out);
  EXPECT_EQ(after["state"], "ended");
  EXPECT_EQ(after["exit_code"], 75);
  EXPECT_EQ(after["stop_reason"], "stopped on request");
  EXPECT_TRUE(after["process"].is_null());
  const Ended again = run({"stop", solve.directory()});
  EXPECT_EQ(again.code, 0);
  EXPECT_TRUE(says(again, "nothing to stop")) << again.err;
}

TEST(Stop, RunThatStillWorksAtTheTimeoutIsAFailure) {
  const Folder folder;
  LongSolve solve(folder);
  ASSERT_TRUE(wait_until([&] { return solve.state() == "solving"; }));
  const long process = *lock_holder(solve.directory() + "/lock");
  ::kill(static_cast<pid_t>(process), SIGSTOP);
  const Ended e = run({"stop", solve.directory(), "--timeout", "50ms"});
  ::kill(static_cast<pid_t>(process), SIGCONT);
  EXPECT_EQ(e.code, 1) << e.err;
  EXPECT_TRUE(says(e, std::to_string(process))) << e.err;
  EXPECT_EQ(solve.end().code, 75);
}

TEST(Status, KilledRunIsInterruptedAndResumeIsNamed) {
  const Folder folder;
  LongSolve solve(folder);
  ASSERT_TRUE(wait_until([&] { return solve.state() == "solving"; }));
  solve.kill_it();
  EXPECT_EQ(solve.state(), "interrupted");
  const Ended e = run({"status", solve.directory(), "--watch"});  // ends at once
  EXPECT_EQ(e.code, 0);
  EXPECT_NE(e.out.find("atrium resume " + solve.directory()), std::string::npos) << e.out;
  EXPECT_EQ(run({"check", solve.directory()}).code, 0);
}

TEST(Status, EndedRunTellsWhyAndADirectoryThatIsNoRunIsAUsageError) {
  const Ended e = run({"status", furnace_run(), "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json status = Json::parse(e.out);
  EXPECT_EQ(status["state"], "ended");
  EXPECT_EQ(status["stop_reason"], "converged");
  EXPECT_EQ(status["exit_code"], 0);
  const Folder folder;
  EXPECT_EQ(run({"status", folder / "none"}).code, 2);
  EXPECT_EQ(run({"stop", folder / "none"}).code, 2);
}

}  // namespace
}  // namespace atrium::testing
