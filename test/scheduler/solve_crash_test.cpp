// A whole solve on a disk that fails, fills up or loses power at any call: it ends with an error
// that names a file, and taken up again on a healthy disk it ends with the bits of a solve that was
// never disturbed.
#include <cstdlib>
#include <iostream>
#include <random>

#include "engine/cluster_record.h"
#include "pagestore/cluster_store.h"
#include "test/agree/scenes.h"
#include "test/pagestore/simulated_disk.h"

namespace atrium::testing {
namespace {

using Fault = SimulatedDisk::Fault;

bool long_tests() { return std::getenv("ATRIUM_LONG_TESTS") != nullptr; }

// What a run holds at its end: a hash for every record of it, braids included.
using Contents = std::map<RecordId, std::uint64_t>;

class SolveCrash : public ::testing::Test {
 protected:
  static constexpr const char* kRun = "run";
  static constexpr std::uint64_t kCallsOfMaking = 60;  // before the first gather, at least
  static constexpr std::uint64_t kSampledMaking = 6;   // one of so many of them, in the suite

  static void SetUpTestSuite() {
    bench_ = std::make_unique<Bench>(two_rooms_model());
    SimulatedDisk disk;
    disk.fault = [](std::uint64_t, const std::string& call) {
      calls_of_.push_back(call);
      return Fault::kNone;
    };
    const Result<SolveSummary> summary = solve_on(disk);
    ASSERT_TRUE(summary.ok()) << summary.status().message();
    // That it does all that may go wrong: records leave the arena and come back, braids are
    // streamed, the disk is written to between any two gathers.
    ASSERT_GT(summary->evictions, 0u);
    ASSERT_GT(summary->reads, 0u);
    ASSERT_GT(summary->checkpoints, summary->iterations * summary->clusters);
    disk.fault = nullptr;
    used_ = disk.used();
    undisturbed_ = contents_of(disk);
    ASSERT_GT(undisturbed_.size(), 2 * summary->clusters);  // clusters, braids, the model
  }
  static void TearDownTestSuite() { bench_.reset(); }

  // Three levels of two sweeps, in the smallest arena and with memory for some of the braids.
  static SolveOptions options() {
    SolveOptions o = bench_->options();
    o.run_directory = kRun;
    o.error = 0.03;
    o.iterations = 6;
    o.min_edge = 0.1;
    o.threads = 1;
    o.memory = std::uint64_t{2200} << 10;
    o.arena = std::uint64_t{540} << 10;
    o.checkpoint_every = 1e-9;
    o.recover = true;
    return o;
  }

  static Result<SolveSummary> solve_on(SimulatedDisk& disk) {
    SolveOptions o = options();
    o.disk = &disk;
    return solve(o, {}, {});
  }

  static Contents contents_of(SimulatedDisk& disk) {
    auto store = ClusterStore::open(kRun, {.disk = &disk}, OpenMode::kReadOnly);
    EXPECT_TRUE(store.ok()) << store.status().message();
    if (!store.ok()) return {};
    const Status whole = (*store)->verify_all();
    EXPECT_TRUE(whole.ok()) << whole.message();
    Contents contents;
    for (const RecordId id : (*store)->record_ids()) {
      const auto bytes = (*store)->stream_in(id);
      EXPECT_TRUE(bytes.ok()) << bytes.status().message();
      if (bytes.ok()) contents[id] = hash_bytes(*bytes);
    }
    return contents;
  }

  static void expect_refused_or_done(const Result<SolveSummary>& summary) {
    if (summary.ok()) return;
    EXPECT_EQ(summary.status().code(), Code::kStore) << summary.status().message();
    EXPECT_FALSE(summary.status().file().empty()) << summary.status().message();
  }

  static void expect_done_with_the_same_bits(SimulatedDisk& disk) {
    disk.fault = nullptr;
    const Result<SolveSummary> summary = solve_on(disk);
    ASSERT_TRUE(summary.ok()) << summary.status().message();
    ASSERT_TRUE(contents_of(disk) == undisturbed_);
  }

  // Of the calls of an undisturbed solve: all of them, or a sample and what makes the run.
  static std::vector<std::uint64_t> some_calls(std::size_t sample) {
    std::vector<std::uint64_t> calls;
    const std::uint64_t all = calls_of_.size();
    const std::uint64_t step = long_tests() ? 1 : all / sample;
    for (std::uint64_t n = 0; n < all;
         n += n < kCallsOfMaking ? std::min(step, kSampledMaking) : step)
      calls.push_back(n);
    return calls;
  }

  static Fault only(bool it_is, Fault fault) { return it_is ? fault : Fault::kNone; }

  static inline std::unique_ptr<Bench> bench_;
  static inline Contents undisturbed_;
  static inline std::vector<std::string> calls_of_;  // what was asked of the disk, in order
  static inline std::uint64_t used_ = 0;             // bytes of the disk, in the end
};

TEST_F(SolveCrash, AnyOneCallFails) {
  const std::vector<std::uint64_t> calls = some_calls(8);
  for (const std::uint64_t n : calls) {
    SCOPED_TRACE("call " + std::to_string(n) + ", " + calls_of_[n]);
    SimulatedDisk disk;
    disk.fault = [n](std::uint64_t call, const std::string&) {
      return only(call == n, Fault::kError);
    };
    expect_refused_or_done(solve_on(disk));
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
  std::cout << calls.size() << " of " << calls_of_.size() << " calls failed\n";
}

TEST_F(SolveCrash, EveryWriteFallsShort) {
  SimulatedDisk disk;
  disk.fault = [](std::uint64_t, const std::string& call) {
    return only(call == "write", Fault::kShort);
  };
  ASSERT_TRUE(solve_on(disk).ok());
  EXPECT_TRUE(contents_of(disk) == undisturbed_);
}

// And again, a few times, while what was lost is made good.
TEST_F(SolveCrash, PowerIsLostAtAnyCall) {
  constexpr int kMostCrashes = 4;
  const std::vector<std::uint64_t> calls = some_calls(8);
  int crashes = 0;
  for (const std::uint64_t n : calls) {
    SCOPED_TRACE("call " + std::to_string(n) + ", " + calls_of_[n]);
    std::mt19937_64 random(n);
    SimulatedDisk disk;
    std::uint64_t at = n;
    for (int crash = 0; crash < kMostCrashes; ++crash) {
      disk.fault = [at](std::uint64_t call, const std::string&) {
        return only(call == at, Fault::kPowerOff);
      };
      expect_refused_or_done(solve_on(disk));
      if (disk.powered) break;
      ++crashes;
      disk.lose_power_and_restart(random());
      at = disk.calls + random() % (calls_of_.size() / 4);
    }
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
  std::cout << calls.size() << " of " << calls_of_.size() << " calls, " << crashes << " crashes\n";
}

// A solve that failed has left a summary; the one that takes it up replaces it.
TEST_F(SolveCrash, PowerIsLostWhileASummaryIsReplaced) {
  constexpr std::uint64_t kCallsOfEnding = 50;
  const std::uint64_t step = long_tests() ? 1 : 5;
  SimulatedDisk failed;
  failed.fault = [left = 1](std::uint64_t call, const std::string& what) mutable {
    return only(call > calls_of_.size() / 2 && what == "read" && left-- > 0, Fault::kError);
  };
  ASSERT_FALSE(solve_on(failed).ok());
  ASSERT_TRUE(failed.exists("run/summary.json"));
  failed.fault = nullptr;
  SimulatedDisk whole = failed;
  ASSERT_TRUE(solve_on(whole).ok());
  for (std::uint64_t n = whole.calls - kCallsOfEnding; n < whole.calls; n += step) {
    SCOPED_TRACE("call " + std::to_string(n));
    SimulatedDisk disk = failed;
    disk.fault = [n](std::uint64_t call, const std::string&) {
      return only(call == n, Fault::kPowerOff);
    };
    static_cast<void>(solve_on(disk));
    ASSERT_FALSE(disk.powered);
    disk.lose_power_and_restart(n);
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
}

// What was to be another run is cut short at every call of its making, and this one too.
TEST_F(SolveCrash, PowerIsLostWhileAnotherRunBecomesThisOne) {
  const std::uint64_t step = long_tests() ? 1 : kSampledMaking;
  for (std::uint64_t n = 0; n < kCallsOfMaking; n += step) {
    SCOPED_TRACE("call " + std::to_string(n));
    std::mt19937_64 random(n);
    SimulatedDisk disk;
    SolveOptions other = options();
    other.error = 0.5;
    other.disk = &disk;
    for (int crash = 0; crash < 2; ++crash) {
      disk.fault = [at = crash == 0 ? n : disk.calls + random() % kCallsOfMaking](
                       std::uint64_t call, const std::string&) {
        return only(call == at, Fault::kPowerOff);
      };
      expect_refused_or_done(crash == 0 ? solve(other, {}, {}) : solve_on(disk));
      disk.lose_power_and_restart(random());
    }
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
}

// The kernel has dropped the pages; the solve stops there, and the machine is started again.
TEST_F(SolveCrash, OneSyncFailsThenPowerIsLost) {
  // Counted by themselves: the status page is written by the clock, and shifts the others.
  const std::size_t syncs = std::ranges::count(calls_of_, "sync");
  const std::size_t step = long_tests() ? 1 : syncs / 8;
  for (std::size_t i = 0; i < syncs; i += step) {
    SCOPED_TRACE("sync " + std::to_string(i));
    SimulatedDisk disk;
    disk.fault = [i, seen = std::size_t{0}](std::uint64_t, const std::string& call) mutable {
      return only(call == "sync" && seen++ == i, Fault::kError);
    };
    const Result<SolveSummary> summary = solve_on(disk);
    EXPECT_FALSE(summary.ok());
    expect_refused_or_done(summary);
    disk.lose_power_and_restart(i);
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
}

// Less and less room, until not even the store can be made.
TEST_F(SolveCrash, DiskFullThenRoomIsMade) {
  const std::uint64_t steps = long_tests() ? 64 : 8;
  for (std::uint64_t i = 0; i < steps; ++i) {
    SCOPED_TRACE("capacity " + std::to_string(i) + "/" + std::to_string(steps));
    SimulatedDisk disk;
    disk.capacity = used_ * i / steps;
    const Result<SolveSummary> summary = solve_on(disk);
    expect_refused_or_done(summary);
    EXPECT_TRUE(summary.ok() || summary.status().remedy().starts_with("make room"));
    disk.capacity = ~std::uint64_t{0};
    expect_done_with_the_same_bits(disk);
    if (HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace atrium::testing
