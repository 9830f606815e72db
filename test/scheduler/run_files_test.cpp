// A run's texts on a disk that tears, fails and loses power.
#include "scheduler/run_files.h"

#include <gtest/gtest.h>

#include "test/pagestore/simulated_disk.h"

namespace atrium {
namespace {

using Fault = SimulatedDisk::Fault;

void cut_power_at(SimulatedDisk& disk, std::uint64_t n) {
  disk.fault = [n](std::uint64_t call, const std::string&) {
    return call == n ? Fault::kPowerOff : Fault::kNone;
  };
}

// Longer than a sector, so that they can tear.
std::string text_of(char c) { return std::string(3 * SimulatedDisk::kSector, c); }

TEST(RunFilesCrash, AFileThatIsReplacedIsTheOldOrTheNewOne) {
  constexpr std::uint64_t kTearings = 16;
  SimulatedDisk old;
  ASSERT_TRUE(RunFiles(old, "run").write(RunFile::kToml, text_of('a')).ok());
  SimulatedDisk whole = old;
  ASSERT_TRUE(RunFiles(whole, "run").write(RunFile::kToml, text_of('b')).ok());
  int kept_old = 0, became_new = 0;
  for (std::uint64_t n = old.calls; n <= whole.calls; ++n)
    for (std::uint64_t tearing = 0; tearing < kTearings; ++tearing) {
      SCOPED_TRACE("call " + std::to_string(n) + ", tearing " + std::to_string(tearing));
      SimulatedDisk disk = old;
      cut_power_at(disk, n);
      const Status written = RunFiles(disk, "run").write(RunFile::kToml, text_of('b'));
      disk.lose_power_and_restart(tearing);
      const Result<std::string> found = RunFiles(disk, "run").read(RunFile::kToml);
      ASSERT_TRUE(found.ok()) << found.status().message();
      ASSERT_TRUE(*found == text_of('b') || (!written.ok() && *found == text_of('a')));
      ++(*found == text_of('a') ? kept_old : became_new);
    }
  EXPECT_GT(kept_old, 0);
  EXPECT_GT(became_new, 0);
}

// A line under way when the power went is there, or not, or torn; what had its sum taken is there,
// and the next line begins on its own.
TEST(RunFilesCrash, LinesBeforeACheckpointAreKeptAndALineAfterACrashIsWhole) {
  constexpr std::uint64_t kTearings = 32;
  for (std::uint64_t tearing = 0; tearing < kTearings; ++tearing) {
    SCOPED_TRACE("tearing " + std::to_string(tearing));
    SimulatedDisk disk;
    RunFiles files(disk, "run");
    ASSERT_TRUE(files.append_line(RunFile::kLog, text_of('a')).ok());
    const Result<RunSums> sums = files.sums();
    ASSERT_TRUE(sums.ok());
    ASSERT_TRUE(files.append_line(RunFile::kLog, text_of('b')).ok());
    disk.lose_power_and_restart(tearing);
    RunFiles again(disk, "run");
    ASSERT_TRUE(again.verify_all(*sums).ok());
    ASSERT_TRUE(again.append_line(RunFile::kLog, text_of('c')).ok());
    const std::string log = again.read(RunFile::kLog).value();
    EXPECT_TRUE(log.starts_with(text_of('a') + "\n"));
    EXPECT_TRUE(log.ends_with("\n" + text_of('c') + "\n"));
  }
}

// Sums are taken while a torn line is still there, which the next one cuts off.
TEST(RunFilesCrash, ATornLineIsNotInTheSums) {
  SimulatedDisk disk;
  RunFiles files(disk, "run");
  ASSERT_TRUE(files.append_line(RunFile::kLog, "whole").ok());
  const std::vector<std::byte> torn(10, std::byte{'t'});
  const auto log = disk.open("run/run.log", DiskAccess::kReadWrite);
  ASSERT_TRUE(log.ok() && write_all(**log, std::string("whole\n").size(), torn).ok());
  const Result<RunSums> sums = files.sums();
  ASSERT_TRUE(sums.ok());
  ASSERT_TRUE(files.append_line(RunFile::kLog, "next").ok());
  EXPECT_EQ(files.read(RunFile::kLog).value(), "whole\nnext\n");
  const Status same = files.verify_all(*sums);
  EXPECT_TRUE(same.ok()) << same.message();
}

TEST(RunFilesCrash, AfterAFailedSyncNoSumsAreTaken) {
  SimulatedDisk disk;
  RunFiles files(disk, "run");
  ASSERT_TRUE(files.append_line(RunFile::kLog, "a").ok());
  disk.fault = [](std::uint64_t, const std::string& call) {
    return call == "sync" ? Fault::kError : Fault::kNone;
  };
  const Status first = files.sums().status();
  ASSERT_FALSE(first.ok());
  disk.fault = nullptr;
  EXPECT_EQ(files.sums().status().message(), first.message());
}

}  // namespace
}  // namespace atrium
