#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "apps/solve_options.h"
#include "scheduler/history.h"
#include "scheduler/order.h"
#include "test/apps/program.h"

namespace atrium::testing {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kCombinations = 200;

class Dice {
 public:
  bool toss() { return (random_() & 1) != 0; }
  std::uint64_t up_to(std::uint64_t most) {
    return std::uniform_int_distribution<std::uint64_t>(0, most)(random_);
  }
  template <class T>
  const T& one_of(const std::vector<T>& items) {
    return items[up_to(items.size() - 1)];
  }
  // From 1e-9 to 1e9, all 53 bits of it in use.
  double number() { return std::pow(10, std::uniform_real_distribution<double>(-9, 9)(random_)); }
  double below_one() { return std::uniform_real_distribution<double>(1e-9, 0.99)(random_); }

 private:
  std::mt19937_64 random_{kSeed};
};

// Anything that the command line could have set.
SolveOptions thrown(Dice& dice) {
  constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max();
  SolveOptions o;
  o.scene.files = {"/scenes/a \"quoted\" name.obj"};
  if (dice.toss()) o.scene.files.push_back("/scenes/back\\slash, comma.gltf");
  if (dice.toss()) o.scene.assign_file = "/scenes/häuser.toml";
  if (dice.toss()) o.scene.drop = {"^door[0-9]+$", "a, b"};
  o.scene.sides =
      dice.one_of<SidesChoice>({SidesChoice::kAuto, SidesChoice::kOne, SidesChoice::kTwo});
  o.scene.unit = dice.one_of<double>({0.0254, 0.3048, 0.001, 0.01, 1, dice.number()});
  o.scene.emission_is_exitance = dice.toss();
  if (dice.toss()) o.scene.white = dice.below_one();
  if (dice.toss()) o.partition.close_gaps = dice.number();
  o.memory = dice.up_to(kMost);
  if (dice.toss()) o.arena = dice.up_to(kMost);
  o.error = dice.below_one();
  if (dice.toss()) o.residual = dice.below_one();
  if (dice.toss()) o.iterations = dice.up_to(kMost);
  if (dice.toss()) o.time_limit = dice.number();
  if (dice.toss()) o.min_edge = dice.number();
  o.order = dice.one_of(order_names());
  if (dice.toss()) o.policy = dice.one_of<std::string>({"lru", "lookahead:7", "belady"});
  o.basis = dice.toss() ? 1 : dice.toss() ? 2 : 3;
  o.links = dice.one_of<std::string>({"keep", "discard", "auto"});
  o.seed = dice.toss() ? dice.up_to(kMost) : 0;
  if (dice.toss()) o.threads = 1 + static_cast<int>(dice.up_to(kMostThreads - 1));
  if (dice.toss()) o.reference = "/scenes/points.csv";
  if (dice.toss()) o.force = {"portals"};
  if (dice.toss()) o.force.push_back("eviction");
  o.io = dice.toss() ? "mmap" : "direct";
  o.checkpoint_every = dice.number();
  if (dice.toss()) o.trace = "/tmp/run.atr";
  if (dice.toss()) o.from = "/runs/before the edit";
  return o;
}

TEST(RunToml, EveryCombinationOfOptionsComesBackByteForByte) {
  const Folder folder;
  Dice dice;
  for (int i = 0; i < kCombinations; ++i) {
    const SolveOptions options = thrown(dice);
    const std::string text = run_toml(options);
    write_file(folder / "run.toml", text);
    SolveOptions back;
    const Status read = read_run_toml(folder / "run.toml", back);
    ASSERT_TRUE(read.ok()) << read.message() << "\n" << text;
    ASSERT_EQ(run_toml(back), text);
    // What the text could leave out on both ways.
    ASSERT_EQ(back.memory, options.memory);
    ASSERT_EQ(back.arena, options.arena);
    ASSERT_EQ(back.iterations, options.iterations);
    ASSERT_EQ(back.seed, options.seed);
    ASSERT_EQ(back.threads, options.threads);
    ASSERT_EQ(back.time_limit, options.time_limit);
    ASSERT_EQ(back.min_edge, options.min_edge);
    ASSERT_EQ(back.scene.unit, options.scene.unit);
    ASSERT_EQ(back.scene.white, options.scene.white);
    ASSERT_EQ(back.partition.close_gaps, options.partition.close_gaps);
    ASSERT_EQ(back.scene.drop, options.scene.drop);
    ASSERT_EQ(back.force, options.force);
    ASSERT_EQ(back.trace, options.trace);
    ASSERT_EQ(back.from, options.from);
  }
}

TEST(RunToml, WhatNoRunWritesIsDamageWithItsFileAndPlace) {
  const Folder folder;
  const std::string path = folder / "run.toml";
  for (const char* line :
       {"memroy = 1", "[solve]\nseed = 1", "error = 0", "seed = [", "io = 1979-05-27"}) {
    write_file(path, std::string("version = \"atrium\"\n") + line + "\n");
    SolveOptions options;
    const Status read = read_run_toml(path, options);
    EXPECT_EQ(read.code(), Code::kStore) << line;
    EXPECT_EQ(read.file(), path) << line;
    EXPECT_EQ(read.place().rfind("line ", 0), 0u) << line << ": " << read.message();
  }
}

TEST(RunToml, ARunOfAnotherVersionIsNoDamage) {
  const Folder folder;
  write_file(folder / "run.toml", "version = \"atrium 0.0.1\"\n");
  SolveOptions options;
  EXPECT_EQ(read_run_toml(folder / "run.toml", options).code(), Code::kUsage);
}

}  // namespace
}  // namespace atrium::testing
