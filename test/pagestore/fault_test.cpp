// Calls to the disk that fail, fall short or find it full.
#include "test/pagestore/simulated_run.h"

namespace atrium {
namespace {

using Fault = SimulatedDisk::Fault;

TEST(DiskFault, WritesThatFallShortAreCarriedOn) {
  SimulatedDisk disk;
  disk.fault = [](std::uint64_t, const std::string& call) {
    return call == "write" ? Fault::kShort : Fault::kNone;
  };
  SimulatedRun run(disk, 1);
  ASSERT_OK(run.create());
  for (int i = 0; i < 300; ++i) ASSERT_OK(run.step());
  ASSERT_OK(run.checkpoint());
  EXPECT_OK(run.store().verify_all());
}

// One call fails, whichever it is; the run goes on as far as it can, then the process ends. What a
// checkpoint said it kept is there.
TEST(DiskFault, AfterAnyOneFailureTheLastCheckpointIsThere) {
  constexpr int kSteps = 80;
  SimulatedDisk whole;
  SimulatedRun undisturbed(whole, 5);
  ASSERT_OK(undisturbed.create());
  for (int i = 0; i < kSteps; ++i) ASSERT_OK(undisturbed.step());
  for (std::uint64_t n = 0; n < whole.calls; ++n) {
    SCOPED_TRACE("call " + std::to_string(n));
    SimulatedDisk disk;
    disk.fault = [n](std::uint64_t call, const std::string&) {
      return call == n ? Fault::kError : Fault::kNone;
    };
    SimulatedRun run(disk, 5);
    if (!run.create().ok()) {
      // The disk is well again: the same command does it now, or finds it done.
      const Status again = run.create();
      if (again.code() == Code::kUsage) continue;
      ASSERT_OK(again);
    }
    for (int i = 0; i < kSteps; ++i) static_cast<void>(run.step());
    run.close();
    auto opened = ClusterStore::open("run", SimulatedRun::options(disk), OpenMode::kRecover);
    ASSERT_TRUE(opened.ok()) << opened.status().message();
    ASSERT_TRUE(run.may_hold(snapshot_of(**opened)));
    ASSERT_OK((*opened)->verify_all());
  }
}

TEST(DiskFault, AfterAFailedSyncNothingIsWrittenAnyMore) {
  SimulatedDisk disk;
  SimulatedRun run(disk, 2);
  ASSERT_OK(run.create());
  for (int i = 0; i < 40; ++i) ASSERT_OK(run.step());
  bool once = false;
  disk.fault = [&once](std::uint64_t, const std::string& call) {
    if (call != "sync" || once) return Fault::kNone;
    once = true;
    return Fault::kError;
  };
  const Status first = run.checkpoint();
  ASSERT_EQ(first.code(), Code::kStore);
  const std::uint64_t calls = disk.calls;
  const Status second = run.checkpoint();
  EXPECT_EQ(second.message(), first.message());
  EXPECT_EQ(disk.calls, calls);  // not retried: the kernel may have dropped the pages
  EXPECT_OK(run.read_everything());
}

// Whichever write of a checkpoint fails, what it had written by then is given up again.
TEST(DiskFault, FailedCheckpointsLeakNoSpace) {
  SimulatedDisk disk;
  const StoreOptions options{.arena_bytes = 64 * kGranule, .policy = "lru", .disk = &disk};
  auto store = ClusterStore::create("run", options).value();
  ASSERT_OK(store->create_record(cluster(0), filled(100'000, 0)));
  ASSERT_OK(store->checkpoint({}));
  const std::uint64_t before = store->file_bytes();
  constexpr std::uint64_t kWrites = 3;      // the record, the directory, the state
  constexpr std::uint64_t kFailures = 900;  // 300 of each: more than a segment has granules
  for (std::uint64_t i = 0; i < kFailures; ++i) {
    (*store->edit(cluster(0))).bytes()[0] = static_cast<std::byte>(i);
    std::uint64_t left = i % kWrites;
    disk.fault = [&left](std::uint64_t, const std::string& call) {
      return call == "write" && left-- == 0 ? Fault::kError : Fault::kNone;
    };
    ASSERT_FALSE(store->checkpoint({}).ok());
  }
  disk.fault = nullptr;
  ASSERT_OK(store->checkpoint({}));
  EXPECT_EQ(store->file_bytes(), before);
}

// Nor do records past the arena whose write fails, new or replaced.
TEST(DiskFault, FailedStreamsLeakNoSpace) {
  constexpr std::uint64_t kFailures = 300;  // more than a segment has granules
  SimulatedDisk disk;
  const StoreOptions options{.arena_bytes = 64 * kGranule, .policy = "lru", .disk = &disk};
  auto store = ClusterStore::create("run", options).value();
  ASSERT_OK(store->stream_out(cluster(0), filled(5000, 0)));
  const std::uint64_t before = store->file_bytes();
  disk.fault = [](std::uint64_t, const std::string& call) {
    return call == "write" ? Fault::kError : Fault::kNone;
  };
  for (std::uint64_t i = 0; i < kFailures; ++i)
    ASSERT_FALSE(store->stream_out(cluster(i % 2), filled(5000, i)).ok());
  disk.fault = nullptr;
  EXPECT_FALSE(store->contains(cluster(1)));
  EXPECT_EQ(copy_of(store->stream_in(cluster(0)).value()), filled(5000, 0));
  ASSERT_OK(store->stream_out(cluster(1), filled(5000, 1)));
  EXPECT_EQ(store->file_bytes(), before);
}

TEST(DiskFault, AFullDiskIsSaidAndLosesNothing) {
  SimulatedDisk disk;
  disk.capacity = 2'000'000;  // one segment of 1 MiB, and less than another
  const StoreOptions options{.arena_bytes = 64 * kGranule, .policy = "lru", .disk = &disk};
  auto store = ClusterStore::create("run", options).value();
  std::map<std::uint64_t, Bytes> expected;
  Status status;
  for (std::uint64_t i = 0; status.ok() && i < 100; ++i) {
    const Bytes bytes = filled(50'000, i);
    status = store->create_record(cluster(i), bytes);
    if (status.ok()) expected[i] = bytes;
  }
  ASSERT_EQ(status.code(), Code::kStore);
  EXPECT_NE(status.cause().find("no space"), std::string::npos);
  // The rest of the disk was used, in a segment smaller than regular, before giving up.
  EXPECT_GT(disk.used(), disk.capacity - 100'000);
  // Room is made: the same store goes on.
  disk.capacity = 20'000'000;
  ASSERT_OK(store->checkpoint(bytes_of("late")));
  for (const auto& [id, bytes] : expected) EXPECT_EQ(contents(*store, cluster(id)), bytes);
  EXPECT_OK(store->verify_all());
}

// What was done before the disk was full can always be made durable: its room was claimed with it.
TEST(DiskFault, OnAFullDiskACheckpointStillSucceeds) {
  constexpr std::uint64_t kRecords = 12;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    SimulatedDisk disk;
    disk.capacity = 1'200'000 + random() % 3'000'000;
    const StoreOptions options{.arena_bytes = 64 * kGranule, .policy = "lru", .disk = &disk};
    auto store = ClusterStore::create("run", options).value();
    std::map<std::uint64_t, Bytes> expected;
    Status status;
    for (std::uint64_t i = 0; status.ok() && i < kRecords; ++i) {
      expected[i] = filled(random() % 50'000, i);
      ASSERT_OK(store->create_record(cluster(i), expected[i]));
    }
    ASSERT_OK(store->checkpoint(bytes_of("0")));
    std::uint64_t epoch = 1;
    while (status.ok()) {  // every record rewritten, larger and larger, until there is no room
      const std::uint64_t id = random() % kRecords;
      auto edit = store->edit(cluster(id));
      status = edit.status();
      if (!edit.ok()) break;
      const std::size_t size = std::min<std::size_t>(expected[id].size() + 3000, 100'000);
      status = edit->resize(size);
      if (!status.ok()) break;
      expected[id] = filled(size, random());
      std::ranges::copy(expected[id], edit->bytes().begin());
      if (random() % 8 == 0) {
        edit = ClusterEdit();
        ASSERT_OK(store->checkpoint(bytes_of(std::to_string(epoch++))));
      }
      if (epoch > 60) break;
    }
    ASSERT_TRUE(status.ok() || status.cause().find("no space") != std::string::npos);
    ASSERT_OK(store->checkpoint(bytes_of("full")));
    store.reset();
    store = ClusterStore::open("run", options, OpenMode::kReadWrite).value();
    EXPECT_EQ(copy_of(store->state()), bytes_of("full"));
    for (const auto& [id, bytes] : expected) EXPECT_EQ(contents(*store, cluster(id)), bytes);
    EXPECT_OK(store->verify_all());
  }
}

TEST(DiskFault, ARunThatEndsOnAFullDiskOpensAtItsLastCheckpoint) {
  SimulatedDisk disk;
  disk.capacity = 2'000'000;
  const StoreOptions options{.arena_bytes = 64 * kGranule, .policy = "lru", .disk = &disk};
  {
    auto store = ClusterStore::create("run", options).value();
    ASSERT_OK(store->create_record(cluster(0), filled(50'000, 0)));
    ASSERT_OK(store->checkpoint(bytes_of("early")));
    for (std::uint64_t i = 1; store->create_record(cluster(i), filled(50'000, i)).ok(); ++i) {
    }
  }
  auto store = ClusterStore::open("run", options, OpenMode::kReadWrite).value();
  EXPECT_EQ(copy_of(store->state()), bytes_of("early"));
  EXPECT_EQ(contents(*store, cluster(0)), filled(50'000, 0));
  EXPECT_EQ(store->record_ids().size(), 1u);
  EXPECT_OK(store->verify_all());
}

}  // namespace
}  // namespace atrium
