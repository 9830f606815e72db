// The machine's own disk: the lock between processes, what reading costs in memory, its two ways to
// a file, and reads under way.
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <numeric>

#include "pagestore/disk.h"
#include "pagestore/machine_file.h"
#include "pagestore/read_queue.h"
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

TEST_F(MachineDiskTest, ReadingManyTimesTheArenaLeavesFewMappedPagesBehind) {
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
  EXPECT_LT(resident_file_bytes(), before + kMostMapped + (std::size_t{1} << 20));
}

TEST_F(MachineDiskTest, ADirectoryThatCannotBeMadeIsAnErrorWithItsPath) {
  std::ofstream(dir_ + "/file") << "in the way";
  const auto store = ClusterStore::create(dir_ + "/file/run", arena_of(4));
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().code(), Code::kStore);
  EXPECT_EQ(store.status().file(), dir_ + "/file/run");
}

TEST_F(MachineDiskTest, AFullDiskIsAnErrorThatSaysToMakeRoom) {
  auto file = machine_disk(Io::kMmap).open("/dev/full", DiskAccess::kReadWrite);
  if (!file.ok()) GTEST_SKIP() << "no /dev/full here";
  const Status status = write_all(**file, 0, bytes_of("anything"));
  EXPECT_EQ(status.code(), Code::kStore);
  EXPECT_NE(status.remedy().find("make room"), std::string::npos) << status.message();
}

// Whole granules aligned to them, as an arena gives.
class Granules {
 public:
  explicit Granules(std::size_t granules, int protection = PROT_READ | PROT_WRITE)
      : size_(granules * kGranule),
        memory_(::mmap(nullptr, size_, protection, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {}
  ~Granules() { ::munmap(memory_, size_); }
  Granules(const Granules&) = delete;
  std::span<std::byte> bytes() { return {static_cast<std::byte*>(memory_), size_}; }

 private:
  std::size_t size_;
  void* memory_;
};

bool equal(std::span<const std::byte> a, std::span<const std::byte> b) {
  return std::ranges::equal(a, b);
}

// A file of random granules beside what it must hold, written and read in any way.
class DirectDiskTest : public StoreTest {
 protected:
  static constexpr std::size_t kFileGranules = 600;  // more than a bounce buffer takes at once

  void SetUp() override {
    const auto file = machine_disk(Io::kDirect).open(path_, DiskAccess::kReadWrite);
    if (!file.ok() && file.status().remedy() == "use --io mmap")
      GTEST_SKIP() << file.status().message();
    ASSERT_OK(file.status());
  }

  std::unique_ptr<DiskFile> open(Io io) {
    auto file = machine_disk(io).open(path_, DiskAccess::kReadWrite);
    EXPECT_TRUE(file.ok()) << file.status().message();
    return std::move(file).value();
  }
  std::unique_ptr<DiskFile> written(Io io) {
    auto file = open(io);
    EXPECT_OK(file->allocate(content_.size()));
    EXPECT_OK(write_all(*file, 0, content_));
    return file;
  }
  std::span<const std::byte> expected(std::uint64_t offset, std::size_t length) const {
    return std::span(content_).subspan(offset, length);
  }

  std::string path_ = dir_ + "/file";
  Bytes content_ = filled(kFileGranules * kGranule, 7);  // a vector: not aligned to granules
};

TEST_F(DirectDiskTest, EachWayReadsWhatTheOtherWrote) {
  for (const auto& [writer, reader] :
       {std::pair(Io::kDirect, Io::kMmap), {Io::kMmap, Io::kDirect}, {Io::kDirect, Io::kDirect}}) {
    content_ = filled(content_.size(), content_.size() + static_cast<std::size_t>(writer));
    const auto out = written(writer);
    Granules whole(kFileGranules);
    ASSERT_OK(open(reader)->read(0, whole.bytes()));
    EXPECT_TRUE(equal(whole.bytes(), content_));
  }
}

TEST_F(DirectDiskTest, ReadsOfAnyOffsetLengthAndAddressGiveTheseBytes) {
  const auto file = written(Io::kDirect);
  Granules memory(kFileGranules + 1);
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    // Every third offset and length of whole granules, into memory that is aligned or is not.
    const std::uint64_t unit = i % 3 == 0 ? kGranule : 1;
    const std::uint64_t offset = random() % (content_.size() / unit) * unit;
    const std::size_t length = random() % ((content_.size() - offset) / unit + 1) * unit;
    const auto into = memory.bytes().subspan(random() % 2 * (random() % kGranule), length);
    ASSERT_OK(file->read(offset, into));
    ASSERT_TRUE(equal(into, expected(offset, length))) << offset << " " << length;
  }
}

TEST_F(DirectDiskTest, AFileThatEndsWithinAGranuleIsReadToItsEndAndNoFurther) {
  constexpr std::uint64_t kEnd = 10 * kGranule + 100;
  written(Io::kDirect).reset();
  ASSERT_EQ(::truncate(path_.c_str(), kEnd), 0);
  const auto file = open(Io::kDirect);
  Granules memory(16);
  const auto tail = memory.bytes().first(kGranule + 100);
  ASSERT_OK(file->read(kEnd - tail.size(), tail));
  EXPECT_TRUE(equal(tail, expected(kEnd - tail.size(), tail.size())));
  for (const auto into : {memory.bytes(), memory.bytes().subspan(1, 12 * kGranule)}) {
    const Status past = file->read(0, into);
    EXPECT_EQ(past.code(), Code::kStore);
    EXPECT_EQ(past.place(), "byte " + std::to_string(kEnd)) << past.message();
  }
}

TEST_F(DirectDiskTest, AFileSystemThatRefusesDirectAccessIsAnErrorThatNamesTheOtherWay) {
  const auto refused = machine_disk(Io::kDirect).open("/proc/self/maps", DiskAccess::kRead);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), Code::kStore);
  EXPECT_EQ(refused.status().remedy(), "use --io mmap") << refused.status().message();
}

TEST_F(DirectDiskTest, AStoreWrittenInOneWayIsReadInTheOther) {
  constexpr std::uint64_t kRecords = 40;
  for (const auto& [writer, reader] :
       {std::pair(Io::kDirect, Io::kMmap), {Io::kMmap, Io::kDirect}}) {
    const std::string dir = dir_ + (writer == Io::kDirect ? "/direct" : "/mapped");
    const auto options = [](Io io) { return StoreOptions{.arena_bytes = 32 * kGranule, .io = io}; };
    {
      auto store = ClusterStore::create(dir, options(writer)).value();
      for (std::uint64_t i = 0; i < kRecords; ++i)
        ASSERT_OK(store->create_record(cluster(i), filled(1000 * i, i)));
      ASSERT_OK(store->checkpoint(bytes_of("state")));
    }
    auto store = ClusterStore::open(dir, options(reader), OpenMode::kReadWrite).value();
    EXPECT_EQ(copy_of(store->state()), bytes_of("state"));
    for (std::uint64_t i = 0; i < kRecords; ++i)
      EXPECT_EQ(contents(*store, cluster(i)), filled(1000 * i, i));
    EXPECT_OK(store->verify_all());
  }
}

// The queues behind both ways; io_uring and its stand-in each by itself.
enum class Queue { kAdvising, kUring, kThreads };

class ReadQueueTest : public DirectDiskTest, public ::testing::WithParamInterface<Queue> {
 protected:
  static constexpr unsigned kDepth = 16;

  void SetUp() override {
    DirectDiskTest::SetUp();
    if (IsSkipped()) return;
    if (GetParam() == Queue::kUring && !make_uring_queue(kDepth).ok())
      GTEST_SKIP() << make_uring_queue(kDepth).status().message();
    file_ = written(GetParam() == Queue::kAdvising ? Io::kMmap : Io::kDirect);
    queue_ = make();
  }

  static std::unique_ptr<ReadQueue> make() {
    switch (GetParam()) {
      case Queue::kAdvising:
        return make_advising_queue();
      case Queue::kUring:
        return make_uring_queue(kDepth).value();
      case Queue::kThreads:
        return make_thread_queue("a test asks for them");
    }
    return nullptr;
  }

  std::unique_ptr<DiskFile> file_;
  std::unique_ptr<ReadQueue> queue_;  // ends before its file does
};

std::string queue_name(const ::testing::TestParamInfo<Queue>& queue) {
  return queue.param == Queue::kAdvising ? "Advising"
         : queue.param == Queue::kUring  ? "Uring"
                                         : "Threads";
}

INSTANTIATE_TEST_SUITE_P(, ReadQueueTest,
                         ::testing::Values(Queue::kAdvising, Queue::kUring, Queue::kThreads),
                         queue_name);

// Far more than the depth, waited for in another order than they were submitted in; each fourth is
// of no whole granules.
TEST_P(ReadQueueTest, HundredsOfReadsInRandomOrderBringTheirOwnBytes) {
  constexpr std::size_t kReads = 500, kLongest = 40;
  struct Read {
    std::uint64_t offset;
    std::span<std::byte> into;
  };
  Granules memory(kReads * kLongest);
  std::mt19937_64 random(2);
  std::vector<Read> reads;
  for (std::size_t i = 0; i < kReads; ++i) {
    const std::size_t bent = i % 4 == 0 ? random() % kGranule : 0;
    const std::size_t length = (1 + random() % kLongest) * kGranule - bent;
    const std::uint64_t first = random() % (kFileGranules - kLongest);
    reads.push_back(
        {first * kGranule + bent, memory.bytes().subspan(i * kLongest * kGranule, length)});
    queue_->submit(*file_, reads[i].offset, reads[i].into, i);
  }
  std::vector<std::size_t> order(kReads);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::shuffle(order, random);
  for (const std::size_t i : order) {
    ASSERT_OK(queue_->wait(i));
    ASSERT_TRUE(equal(reads[i].into, expected(reads[i].offset, reads[i].into.size()))) << i;
  }
}

TEST_P(ReadQueueTest, ATicketWaitedForMayBeUsedAgain) {
  Granules memory(1);
  for (std::uint64_t granule = 0; granule < 3; ++granule) {
    queue_->submit(*file_, granule * kGranule, memory.bytes(), 5);
    ASSERT_OK(queue_->wait(5));
    EXPECT_TRUE(equal(memory.bytes(), expected(granule * kGranule, kGranule)));
  }
}

TEST_P(ReadQueueTest, AReadPastTheEndIsAnErrorAndThoseBesideItAreNot) {
  Granules memory(12);
  const std::uint64_t last = content_.size() - 4 * kGranule;
  const auto good = memory.bytes().first(4 * kGranule);
  queue_->submit(*file_, last, memory.bytes().subspan(4 * kGranule), 1);
  queue_->submit(*file_, last, good, 2);
  queue_->submit(*file_, content_.size(), memory.bytes().last(kGranule), 3);
  EXPECT_OK(queue_->wait(2));
  EXPECT_TRUE(equal(good, expected(last, good.size())));
  for (const std::uint64_t ticket : {1, 3}) {
    const Status past = queue_->wait(ticket);
    EXPECT_EQ(past.code(), Code::kStore);
    EXPECT_EQ(past.file(), path_);
    EXPECT_EQ(past.place(), "byte " + std::to_string(content_.size())) << past.message();
  }
}

// Of queues that hand the caller's memory to the kernel: a wrong address is a read that fails.
class DirectQueueTest : public ReadQueueTest {};

INSTANTIATE_TEST_SUITE_P(, DirectQueueTest, ::testing::Values(Queue::kUring, Queue::kThreads),
                         queue_name);

TEST_P(DirectQueueTest, AReadThatTheKernelFailsIsAnError) {
  Granules nowhere(1, PROT_NONE), somewhere(1);
  queue_->submit(*file_, kGranule, nowhere.bytes(), 1);
  queue_->submit(*file_, kGranule, somewhere.bytes(), 2);
  const Status failed = queue_->wait(1);
  EXPECT_EQ(failed.code(), Code::kStore);
  EXPECT_EQ(failed.file(), path_);
  EXPECT_EQ(failed.place(), "byte " + std::to_string(kGranule)) << failed.message();
  EXPECT_OK(queue_->wait(2));
}

TEST_P(ReadQueueTest, AQueueThatIsGoneWritesNothingAnyMore) {
  constexpr std::size_t kReads = 100;
  Granules memory(kReads * 4), probe(kFileGranules);
  for (int round = 0; round < 5; ++round) {
    for (std::size_t i = 0; i < kReads; ++i)
      queue_->submit(*file_, i * kGranule, memory.bytes().subspan(i * 4 * kGranule, 4 * kGranule),
                     i);
    queue_.reset();
    std::ranges::fill(memory.bytes(), std::byte{0xA5});
    queue_ = make();
    // By when this has come in, what was submitted before it would have come in too.
    queue_->submit(*file_, 0, probe.bytes(), 0);
    ASSERT_OK(queue_->wait(0));
    EXPECT_TRUE(
        std::ranges::all_of(memory.bytes(), [](std::byte b) { return b == std::byte{0xA5}; }));
    EXPECT_TRUE(equal(probe.bytes(), content_));
    queue_ = make();
  }
}

TEST_F(DirectDiskTest, TheQueueOfADiskSaysHowItReads) {
  EXPECT_EQ(machine_disk(Io::kMmap).read_queue(16)->name(), "advice");
  const bool uring = make_uring_queue(16).ok();
  const std::string name = machine_disk(Io::kDirect).read_queue(16)->name();
  EXPECT_TRUE(uring ? name == "io_uring" : name.starts_with("4 pread threads (")) << name;
}

}  // namespace
}  // namespace atrium
