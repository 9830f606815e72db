// The machine's own disk: the lock between processes, and what reading costs in memory.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "pagestore/disk.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

class MachineDiskTest : public StoreTest {
 protected:
  // Pages of files in this process's resident set, bytes.
  static std::size_t resident_file_bytes() {
    std::ifstream statm("/proc/self/statm");
    std::size_t size = 0, resident = 0, shared = 0;
    statm >> size >> resident >> shared;
    return shared * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  }
};

TEST_F(MachineDiskTest, ASecondWriterIsRefusedWithTheFirstOnesProcessId) {
  make(4).reset();
  int ready[2], done[2];
  ASSERT_EQ(::pipe(ready), 0);
  ASSERT_EQ(::pipe(done), 0);
  const pid_t first = ::fork();
  if (first == 0) {
    ::close(done[1]);
    auto store = ClusterStore::open(dir_, arena_of(4), OpenMode::kReadWrite);
    char c = store.ok() ? 'y' : 'n';
    if (::write(ready[1], &c, 1) != 1) ::_exit(1);
    if (::read(done[0], &c, 1) < 0) ::_exit(1);  // until the other end is closed
    ::_exit(0);
  }
  char c = 0;
  ASSERT_EQ(::read(ready[0], &c, 1), 1);
  ASSERT_EQ(c, 'y');
  const auto refused = ClusterStore::open(dir_, arena_of(4), OpenMode::kReadWrite);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), Code::kStore);
  EXPECT_EQ(refused.status().cause(), "in use by process " + std::to_string(first));
  EXPECT_EQ(ClusterStore::create(dir_, arena_of(4)).status().code(), Code::kStore);
  EXPECT_TRUE(ClusterStore::open(dir_, arena_of(4), OpenMode::kReadOnly).ok());

  ASSERT_EQ(::kill(first, SIGKILL), 0);  // and however the first one ends, the lock goes with it
  ASSERT_EQ(::waitpid(first, nullptr, 0), first);
  EXPECT_TRUE(ClusterStore::open(dir_, arena_of(4), OpenMode::kReadWrite).ok());
  for (const int fd : {ready[0], ready[1], done[0], done[1]}) ::close(fd);
}

TEST_F(MachineDiskTest, ReadingManyTimesTheArenaLeavesNoMappedPagesBehind) {
  constexpr std::uint64_t kRecords = 256;
  constexpr std::size_t kBytes = 250'000;  // 64 MB in all
  auto store = make(512);                  // 2 MiB
  for (std::uint64_t i = 0; i < kRecords; ++i)
    ASSERT_OK(store->create_record(cluster(i), filled(kBytes, i % 4)));
  ASSERT_OK(store->checkpoint({}));
  const std::size_t before = resident_file_bytes();
  std::vector<RecordId> schedule;
  for (std::uint64_t i = 0; i < kRecords; ++i) schedule.push_back(cluster(i));
  store->foresee(schedule);
  for (const RecordId id : schedule) ASSERT_TRUE(store->read(id).ok());
  EXPECT_EQ(store->counters().reads, kRecords);
  EXPECT_LT(resident_file_bytes(), before + (std::size_t{1} << 20));
}

TEST_F(MachineDiskTest, ADirectoryThatCannotBeMadeIsAnErrorWithItsPath) {
  std::ofstream(dir_ + "/file") << "in the way";
  const auto store = ClusterStore::create(dir_ + "/file/run", arena_of(4));
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().code(), Code::kStore);
  EXPECT_EQ(store.status().file(), dir_ + "/file/run");
}

TEST_F(MachineDiskTest, AFullDiskIsAnErrorThatSaysToMakeRoom) {
  auto file = machine_disk().open("/dev/full", DiskAccess::kReadWrite);
  if (!file.ok()) GTEST_SKIP() << "no /dev/full here";
  const Status status = write_all(**file, 0, bytes_of("anything"));
  EXPECT_EQ(status.code(), Code::kStore);
  EXPECT_NE(status.remedy().find("make room"), std::string::npos) << status.message();
}

}  // namespace
}  // namespace atrium
