// The program is killed at any time, again and again, and finishes with the solution of a run that
// was left alone: atrium solve, kill -9, the same command once more.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <iostream>
#include <random>
#include <thread>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

using Words = std::vector<std::string>;
using Seconds = std::chrono::duration<double>;

// A child that writes to nowhere.
pid_t start(const Words& words) {
  std::vector<char*> arguments{const_cast<char*>(ATRIUM_PROGRAM)};
  for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child != 0) return child;
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nowhere, stream);
  execv(ATRIUM_PROGRAM, arguments.data());
  _exit(127);
}

// Whether it was killed: it may have ended before.
bool kill_after(pid_t child, Seconds delay) {
  std::this_thread::sleep_for(delay);
  kill(child, SIGKILL);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status) || WEXITSTATUS(status) == 0) << WEXITSTATUS(status);
  return WIFSIGNALED(status);
}

class Kill : public ::testing::Test {
 protected:
  // In little memory, so that records are evicted and braids streamed.
  static void SetUpTestSuite() {
    folder_ = std::make_unique<Folder>();
    ASSERT_EQ(run({"gen", "rooms", "--grid", "2", "-o", scene()}).code, 0);
    const auto begin = std::chrono::steady_clock::now();
    ASSERT_EQ(run(solve("undisturbed", "mmap", "keep")).code, 0);
    duration_ = std::chrono::steady_clock::now() - begin;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string scene() { return *folder_ / "rooms.obj"; }

  static Words solve(const std::string& name, const std::string& io, const std::string& links) {
    return {"solve",   scene(),  "-o",      *folder_ / name, "--memory",           "3MiB",
            "--arena", "600KiB", "--error", "30%",           "--threads",          "1",
            "--io",    io,       "--links", links,           "--checkpoint-every", "50ms"};
  }

  static std::string exported(const std::string& name) {
    const std::string csv = *folder_ / (name + ".csv");
    const Ended ended = run({"export", *folder_ / name, "-o", csv});
    EXPECT_EQ(ended.code, 0) << ended.err;
    return read_file(csv);
  }

  static void kill_and_compare(const std::string& io, const std::string& links, int kills) {
    kill_and_compare(
        io + links, [&](const std::string& name) { return solve(name, io, links); }, kills);
  }

  // Kills of runs of this kind, a new run after every end; each ends as the undisturbed one.
  // solve: the words that solve into a run of that name.
  static void kill_and_compare(const std::string& name,
                               const std::function<Words(const std::string&)>& solve,
                               int kills) {
    ASSERT_EQ(run(solve(name + "-whole")).code, 0);
    const std::string expected = exported(name + "-whole");
    ASSERT_FALSE(expected.empty());
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> share(0, 1);
    int killed = 0, finished = 0;
    while (killed < kills) {
      const Words words = solve(name);
      bool ended = false;
      for (int i = 0; i < kKillsOfARun && killed < kills && !ended; ++i) {
        ended = !kill_after(start(words), share(random) * duration_);
        killed += ended ? 0 : 1;
      }
      const Ended rest = run(words);
      ASSERT_EQ(rest.code, 0) << rest.err;
      ASSERT_EQ(exported(name), expected);
      ++finished;
      std::filesystem::remove_all(*folder_ / name);
    }
    std::cout << killed << " kills, " << finished << " runs finished\n";
  }

  static constexpr int kKillsOfARun = 5;
  static inline std::unique_ptr<Folder> folder_;
  static inline Seconds duration_{};
};

// Of each kind of run; in the long variant more than a hundred in all.
int kills() { return std::getenv("ATRIUM_LONG_TESTS") != nullptr ? 30 : 2; }

TEST_F(Kill, MappedKeepingLinks) { kill_and_compare("mmap", "keep", kills()); }
TEST_F(Kill, MappedDiscardingLinks) { kill_and_compare("mmap", "discard", kills()); }
TEST_F(Kill, DirectKeepingLinks) { kill_and_compare("direct", "keep", kills()); }
TEST_F(Kill, DirectDiscardingLinks) { kill_and_compare("direct", "discard", kills()); }

// One lamp of four is dimmed.
TEST_F(Kill, StartedFromTheRunBeforeAnEdit) {
  std::string obj = read_file(scene()), mtl = read_file(*folder_ / "rooms.mtl");
  const std::size_t lamp = obj.find("usemtl", obj.find("o room1_1/lamp"));
  const std::string paint = obj.substr(lamp + 7, obj.find('\n', lamp) - lamp - 7);
  obj.replace(lamp + 7, paint.size(), "dimmed");
  obj.replace(obj.find("rooms.mtl"), 9, "edited.mtl");
  write_file(*folder_ / "edited.obj", obj);
  write_file(*folder_ / "edited.mtl", mtl + "\nnewmtl dimmed\nKd 0.5 0.5 0.5\nKe 100 100 100\n");
  const auto solve_edited = [](const std::string& name) {
    Words words = solve(name, "mmap", "keep");
    words[1] = *folder_ / "edited.obj";
    words.insert(words.end(), {"--from", *folder_ / "undisturbed"});
    return words;
  };
  kill_and_compare("edited", solve_edited, kills());
  const Ended summary = run({"inspect", *folder_ / "edited-whole", "--json"});
  EXPECT_NE(summary.out.find("\"clusters_reached\""), std::string::npos) << summary.out;
}

}  // namespace
}  // namespace atrium::testing
