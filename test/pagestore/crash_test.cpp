// Power is lost at any call: every barrier before it holds, and of the writes after the last
// barrier any subset, torn or whole, has reached the disk. The store must open as of the last
// checkpoint, or as of the one that was under way.
#include <cstdlib>
#include <iostream>

#include "test/pagestore/simulated_run.h"

namespace atrium {
namespace {

using Fault = SimulatedDisk::Fault;

// Runs until the power goes at call `n` or `steps` are done; says whether it went.
bool run_until_power_goes(SimulatedDisk& disk, SimulatedRun& run, std::uint64_t n, int steps) {
  disk.fault = [n](std::uint64_t call, const std::string&) {
    return call == n ? Fault::kPowerOff : Fault::kNone;
  };
  if (!run.kept.has_value()) static_cast<void>(run.create());
  for (int i = 0; i < steps && disk.powered; ++i) static_cast<void>(run.step());
  run.close();
  return !disk.powered;
}

bool long_tests() { return std::getenv("ATRIUM_LONG_TESTS") != nullptr; }

// The power goes while the store is being opened, until it stays.
std::uint64_t crash_while_opening(SimulatedDisk& disk, std::mt19937_64& random) {
  constexpr std::uint64_t kCallsOfOpening = 24;  // and more: not every attempt is cut short
  std::uint64_t crashes = 0;
  while (random() % 3 == 0) {
    disk.fault = [n = disk.calls + random() % kCallsOfOpening](std::uint64_t call,
                                                               const std::string&) {
      return call == n ? Fault::kPowerOff : Fault::kNone;
    };
    static_cast<void>(ClusterStore::open("run", SimulatedRun::options(disk), OpenMode::kRecover));
    crashes += disk.powered ? 0 : 1;
    disk.lose_power_and_restart(random());
  }
  return crashes;
}

// Opens what the crash left and checks it; the run goes on with it.
void recover(SimulatedDisk& disk, SimulatedRun& run) {
  auto opened = ClusterStore::open("run", SimulatedRun::options(disk), OpenMode::kRecover);
  if (!opened.ok()) {  // only a store that was never finished may be missing, and is made anew
    ASSERT_FALSE(run.kept.has_value()) << opened.status().message();
    ASSERT_OK(run.create());
    return;
  }
  auto store = std::move(opened).value();
  const Snapshot found = snapshot_of(*store);
  ASSERT_TRUE(run.may_hold(found));
  ASSERT_OK(store->verify_all());
  run.adopt(std::move(store), found);
}

TEST(Crash, AtEveryCallOfARunWithSeveralTearings) {
  constexpr int kSteps = 60;
  constexpr std::uint64_t kTearings = 4;
  SimulatedDisk whole;
  SimulatedRun undisturbed(whole, 1);
  ASSERT_FALSE(run_until_power_goes(whole, undisturbed, ~std::uint64_t{0}, kSteps));
  ASSERT_GT(whole.calls, 50u);
  for (std::uint64_t n = 0; n < whole.calls; ++n)
    for (std::uint64_t tearing = 0; tearing < kTearings; ++tearing) {
      SCOPED_TRACE("call " + std::to_string(n) + ", tearing " + std::to_string(tearing));
      SimulatedDisk disk;
      SimulatedRun run(disk, 1);
      ASSERT_TRUE(run_until_power_goes(disk, run, n, kSteps));
      disk.lose_power_and_restart(tearing);
      recover(disk, run);
      if (HasFatalFailure()) return;
    }
}

// Several crashes in a row, of the run and of opening after it, each with a tearing of its own.
TEST(Crash, AgainAndAgainInOneRun) {
  const std::uint64_t seeds = long_tests() ? 10'000 : 500;
  constexpr int kCrashes = 4;
  constexpr int kSteps = 120;
  constexpr std::uint64_t kCallsBetween = 150;
  constexpr std::uint64_t kSmallDisk = 80 * kGranule;
  std::uint64_t crashes = 0, while_opening = 0, grown = 0;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(seed);
    SimulatedDisk disk;
    disk.capacity = kSmallDisk;  // so that the first segment is small, and others follow later
    SimulatedRun run(disk, seed);
    for (int crash = 0; crash < kCrashes; ++crash) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", crash " + std::to_string(crash));
      crashes += run_until_power_goes(disk, run, disk.calls + random() % kCallsBetween, kSteps);
      disk.lose_power_and_restart(random());
      while_opening += crash_while_opening(disk, random);
      recover(disk, run);
      if (HasFatalFailure()) return;
      disk.capacity = ~std::uint64_t{0};
    }
    grown += disk.exists("run/pages.0001") ? 1 : 0;
  }
  std::cout << seeds << " seeds: " << crashes << " crashes, " << while_opening
            << " more while opening, " << grown << " stores of several segments\n";
  EXPECT_GT(crashes, seeds * kCrashes / 2);
  EXPECT_GT(while_opening, seeds / 2);
  EXPECT_GT(grown, seeds / 10);
}

// A store's making is cut short, made again, and then the power goes at once.
TEST(Crash, WhatCreateReturnedIsDurableThoughAnEarlierAttemptWasCutShort) {
  constexpr std::uint64_t kTearings = 60;
  SimulatedDisk whole;
  ASSERT_OK(SimulatedRun(whole, 1).create());
  for (std::uint64_t n = 0; n < whole.calls; ++n)
    for (std::uint64_t tearing = 0; tearing < kTearings; ++tearing) {
      SCOPED_TRACE("call " + std::to_string(n) + ", tearing " + std::to_string(tearing));
      SimulatedDisk disk;
      SimulatedRun run(disk, 1);
      run_until_power_goes(disk, run, n, 0);
      disk.lose_power_and_restart(tearing);
      recover(disk, run);
      if (HasFatalFailure()) return;
      run.close();
      disk.lose_power_and_restart(tearing + 1);
      EXPECT_TRUE(ClusterStore::open("run", SimulatedRun::options(disk), OpenMode::kRecover).ok());
    }
}

// A root that verifies must lead to contents that verify, the older as well as the newer: after any
// crash the newest root may go bad later, and the one before it is what is left.
TEST(Crash, TheOlderRootIsWholeAtEveryCall) {
  constexpr std::uint64_t kSeeds = 60;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SimulatedDisk disk;
    SimulatedRun run(disk, seed);
    ASSERT_OK(run.create());
    std::optional<Snapshot> before;
    for (int i = 0; i < 80; ++i) {
      const std::optional<Snapshot> last = run.kept;
      ASSERT_OK(run.step());
      if (run.kept != last) before = last;
    }
    if (!before) continue;
    const std::uint64_t newest = run.store().epoch();
    run.close();
    auto& roots = disk.files["run/roots"];
    roots.now[(newest & 1) * kGranule + 100] ^= std::byte{1};
    auto opened = ClusterStore::open("run", SimulatedRun::options(disk), OpenMode::kRecover);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    EXPECT_FALSE((*opened)->recovery_note().ok());
    EXPECT_EQ(snapshot_of(**opened), *before);
  }
}

}  // namespace
}  // namespace atrium
