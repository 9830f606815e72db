#include "pagestore/cluster_store.h"

#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

// Payload bytes of a record that takes exactly this many granules.
constexpr std::size_t payload_of_granules(std::size_t n) {
  return n * kGranule - sizeof(RecordHeader);
}

class ClusterStoreTest : public StoreTest {};

TEST_F(ClusterStoreTest, RecordsOfEverySizeComeBackAsTheyWere) {
  const std::size_t sizes[] = {0, 1, 63, 64, 4031, 4032, 4033, 100'000, 3'000'000};
  {
    auto store = make(1024);
    for (std::size_t i = 0; i < std::size(sizes); ++i)
      ASSERT_OK(store->create_record(cluster(i), filled(sizes[i], i)));
    ASSERT_OK(store->checkpoint(bytes_of("iteration 3")));
  }
  auto store = reopen(1024, OpenMode::kReadOnly);
  EXPECT_EQ(copy_of(store->state()), bytes_of("iteration 3"));
  for (std::size_t i = 0; i < std::size(sizes); ++i) {
    auto pin = store->read(cluster(i));
    ASSERT_TRUE(pin.ok()) << pin.status().message();
    EXPECT_EQ(copy_of((*pin).bytes()), filled(sizes[i], i));
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>((*pin).bytes().data()) % 64, 0u);
    EXPECT_EQ(store->size(cluster(i)), sizes[i]);
  }
  EXPECT_OK(store->verify_all());
}

TEST_F(ClusterStoreTest, WhatWasNotCheckpointedIsGoneAfterReopening) {
  {
    auto store = make(16);
    ASSERT_OK(store->create_record(cluster(1), bytes_of("old")));
    ASSERT_OK(store->checkpoint({}));
    (*store->edit(cluster(1))).bytes()[0] = std::byte{'X'};
    ASSERT_OK(store->create_record(cluster(2), bytes_of("never kept")));
  }
  auto store = reopen(16);
  EXPECT_EQ(contents(*store, cluster(1)), bytes_of("old"));
  EXPECT_FALSE(store->contains(cluster(2)));
}

TEST_F(ClusterStoreTest, GrowthKeepsContentAndZeroesTheRest) {
  auto store = make(64);
  const Bytes old = filled(5000, 1);
  ASSERT_OK(store->create_record(cluster(0), old));
  ASSERT_OK(store->create_record(cluster(1), filled(5000, 2)));  // in the way of growing in place
  {
    auto edit = store->edit(cluster(0));
    ASSERT_TRUE(edit.ok());
    for (const std::size_t size : {5001u, 9000u, 50'000u, 200'000u}) {
      ASSERT_OK(edit->resize(size));
      Bytes expected = old;
      expected.resize(size);
      ASSERT_EQ(copy_of(edit->bytes()), expected);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(edit->bytes().data()) % 64, 0u);
    }
    ASSERT_OK(edit->resize(100));  // and what shrinks and grows again is zero there too
    ASSERT_OK(edit->resize(300));
    Bytes expected(old.begin(), old.begin() + 100);
    expected.resize(300);
    EXPECT_EQ(copy_of(edit->bytes()), expected);
  }
  EXPECT_EQ(contents(*store, cluster(1)), filled(5000, 2));
  EXPECT_EQ(store->live_bytes(RecordKind::kCluster), 5300u);
  EXPECT_EQ(store->arena_used_bytes(),
            ClusterStore::arena_cost(300) + ClusterStore::arena_cost(5000));
}

TEST_F(ClusterStoreTest, ARecordMayGrowOverItsOwnPlaceInATightArena) {
  auto store = make(10);
  const Bytes old = filled(payload_of_granules(6), 7);
  ASSERT_OK(store->create_record(cluster(0), filled(100, 0)));  // granule 0
  ASSERT_OK(store->create_record(cluster(1), old));             // granules 1 to 6
  auto edit = store->edit(cluster(1));
  ASSERT_TRUE(edit.ok());
  ASSERT_OK(edit->resize(payload_of_granules(10)));  // must move down by one over itself
  EXPECT_EQ(copy_of(edit->bytes().first(old.size())), old);
  EXPECT_EQ(store->counters().evictions, 1u);
  const Status status = edit->resize(payload_of_granules(10) + 1);
  EXPECT_EQ(status.code(), Code::kUsage);
  EXPECT_NE(status.remedy().find(std::to_string(11 * kGranule)), std::string::npos)
      << status.message();
  EXPECT_EQ(copy_of(edit->bytes().first(old.size())), old);  // as it was
}

TEST_F(ClusterStoreTest, PinsAreNeverEvictedNorMoved) {
  auto store = make(8);
  for (std::uint64_t i = 0; i < 20; ++i)
    ASSERT_OK(store->create_record(cluster(i), filled(payload_of_granules(2), i)));
  auto pin = store->read(cluster(3));
  auto again = store->read(cluster(3));
  ASSERT_TRUE(pin.ok() && again.ok());
  const std::byte* place = pin->bytes().data();
  EXPECT_EQ(place, again->bytes().data());
  for (std::uint64_t i = 0; i < 20; ++i)
    EXPECT_EQ(contents(*store, cluster(i)), filled(payload_of_granules(2), i));
  EXPECT_EQ(pin->bytes().data(), place);
  EXPECT_EQ(copy_of(pin->bytes()), filled(payload_of_granules(2), 3));
  EXPECT_EQ(store->pinned_bytes(), 2 * kGranule);
  pin = ClusterPin();
  EXPECT_EQ(store->pinned_bytes(), 2 * kGranule);  // the other one still holds it
  again = ClusterPin();
  EXPECT_EQ(store->pinned_bytes(), 0u);
}

TEST_F(ClusterStoreTest, TheArenaIsExactAndSaysHowLargeItHadToBe) {
  auto store = make(8);
  for (std::uint64_t i = 0; i < 5; ++i)
    ASSERT_OK(store->create_record(cluster(i), filled(payload_of_granules(2), i)));
  std::vector<ClusterPin> pins;
  for (std::uint64_t i = 0; i < 4; ++i) {
    auto pin = store->read(cluster(i));
    ASSERT_TRUE(pin.ok());
    pins.push_back(std::move(pin).value());
  }
  const auto refused = store->read(cluster(4));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().code(), Code::kUsage);
  EXPECT_NE(refused.status().place().find("cluster 4"), std::string::npos);
  EXPECT_NE(refused.status().remedy().find(std::to_string(10 * kGranule)), std::string::npos)
      << refused.status().message();
  EXPECT_EQ(store->arena_peak_bytes(), 8 * kGranule);
  pins.pop_back();
  EXPECT_TRUE(store->read(cluster(4)).ok());

  const Status too_big = store->create_record(cluster(9), filled(payload_of_granules(8) + 1, 0));
  EXPECT_EQ(too_big.code(), Code::kUsage);
  EXPECT_FALSE(store->contains(cluster(9)));
}

TEST_F(ClusterStoreTest, PinsThatPartTheArenaAreNamedAsTheCause) {
  constexpr std::uint64_t kPairs = 20;
  auto store = make(2 * kPairs);
  for (std::uint64_t i = 0; i < kPairs; ++i)  // granules 0-1, 2-3, …
    ASSERT_OK(store->create_record(cluster(i), filled(payload_of_granules(2), i)));
  std::vector<ClusterPin> pins;  // of every fifth pair: between them at most 8 granules
  for (std::uint64_t i = 0; i < kPairs; i += 5) pins.push_back(store->read(cluster(i)).value());
  const std::size_t room = 2 * (kPairs - kPairs / 5);
  const std::size_t beyond = ClusterStore::arena_memory(2 * kPairs * kGranule) / kGranule -
                             2 * (kPairs - 4);  // the last run of all, behind the last pin
  ASSERT_LT(beyond, room);
  const Status status = store->create_record(cluster(99), filled(payload_of_granules(room), 3));
  EXPECT_EQ(status.code(), Code::kUsage);
  EXPECT_NE(status.cause().find("part them"), std::string::npos) << status.message();
}

// Every other record goes, and one as large as several of the holes comes: it fits without another
// having to leave.
TEST_F(ClusterStoreTest, HolesAreSlidTogetherBeforeAnythingIsEvictedForThem) {
  constexpr std::uint64_t kRecords = 64;
  auto store = make(2 * kRecords);
  for (std::uint64_t i = 0; i < kRecords; ++i)
    ASSERT_OK(store->create_record(cluster(i), filled(payload_of_granules(2), i)));
  for (std::uint64_t i = 0; i < kRecords; i += 2) contents(*store, cluster(i));  // recent ones
  const auto pin = store->read(cluster(10));
  ASSERT_TRUE(pin.ok());
  const std::byte* place = pin->bytes().data();
  ASSERT_OK(store->create_record(cluster(99), filled(payload_of_granules(60), 99)));
  EXPECT_EQ(store->counters().evictions, 30u);  // of two granules each
  EXPECT_EQ(store->counters().fragmentation_evictions, 0u);
  EXPECT_EQ(store->counters().compactions, 1u);
  EXPECT_EQ(pin->bytes().data(), place);
  const StoreCounters before = store->counters();
  for (std::uint64_t i = 0; i < kRecords; i += 2)
    EXPECT_EQ(contents(*store, cluster(i)), filled(payload_of_granules(2), i));
  EXPECT_EQ(contents(*store, cluster(99)), filled(payload_of_granules(60), 99));
  EXPECT_EQ((store->counters() - before).reads, 0u);
}

// Reading ahead and knowing the future change neither what is in the arena nor what is counted.
TEST_F(ClusterStoreTest, WhatIsForeseenIsCountedAsWhatIsNot) {
  constexpr std::uint64_t kRecords = 40;
  constexpr std::size_t kArena = 64;
  {
    auto store = make(kArena);
    for (std::uint64_t i = 0; i < kRecords; ++i)
      ASSERT_OK(store->create_record(cluster(i), filled(1 + i * 700, i)));
    ASSERT_OK(store->checkpoint({}));
  }
  std::mt19937_64 random(9);
  std::vector<RecordId> schedule(3000);
  for (RecordId& id : schedule) id = cluster(random() % kRecords);
  const auto run = [&](bool told) {
    auto store = reopen(kArena);
    for (std::size_t i = 0; i < schedule.size(); ++i) {
      if (told && i % 500 == 0) store->foresee(std::span(schedule).subspan(i, 500));
      EXPECT_EQ(contents(*store, schedule[i]), filled(1 + index_of(schedule[i]) * 700,
                                                      index_of(schedule[i])));
      if (i % 700 == 13) (*store->edit(cluster(3))).bytes()[0] = std::byte{0x11};  // not foreseen
      if (i % 700 == 13) (*store->edit(cluster(3))).bytes()[0] = filled(1, 3)[0];
      EXPECT_LE(store->arena_used_bytes(), kArena * kGranule);
    }
    return store->counters();
  };
  const StoreCounters plain = run(false), told = run(true);
  EXPECT_EQ(told.requests, plain.requests);
  EXPECT_EQ(told.reads, plain.reads);
  EXPECT_EQ(told.writes, plain.writes);
  EXPECT_EQ(told.evictions, plain.evictions);
  EXPECT_GT(plain.evictions, 1000u);
}

TEST_F(ClusterStoreTest, StreamedRecordsPassTheArenaAndAreKeptByCheckpoints) {
  auto store = make(4);
  const Bytes large = filled(payload_of_granules(30), 1);  // far larger than the arena
  ASSERT_OK(store->stream_out(cluster(7), large));
  ASSERT_OK(store->checkpoint({}));
  ASSERT_OK(store->stream_out(cluster(7), bytes_of("second")));
  ASSERT_OK(store->stream_out(cluster(7), bytes_of("third")));
  EXPECT_EQ(copy_of(store->stream_in(cluster(7)).value()), bytes_of("third"));
  EXPECT_EQ(store->counters().requests, 0u);
  EXPECT_EQ(store->counters().writes, 0u);
  EXPECT_EQ(store->counters().streamed_writes, 3u);
  EXPECT_EQ(store->live_bytes(), 5u);
  store.reset();  // not checkpointed
  store = reopen(4);
  EXPECT_EQ(copy_of(store->stream_in(cluster(7)).value()), large);
  EXPECT_OK(store->verify_all());
}

TEST_F(ClusterStoreTest, WritesAreDeferredToEvictionOrCheckpoint) {
  auto store = make(4);  // holds two records of two granules
  for (std::uint64_t i = 0; i < 2; ++i)
    ASSERT_OK(store->create_record(cluster(i), filled(payload_of_granules(2), i)));
  EXPECT_EQ(store->counters().writes, 0u);
  ASSERT_OK(store->create_record(cluster(2), filled(payload_of_granules(2), 2)));
  EXPECT_EQ(store->counters().writes, 1u);  // cluster 0, released longest ago
  EXPECT_EQ(store->counters().checkpoint_writes, 0u);
  ASSERT_OK(store->checkpoint({}));
  EXPECT_EQ(store->counters().writes, 3u);
  EXPECT_EQ(store->counters().checkpoint_writes, 2u);
  EXPECT_EQ(store->counters().bytes_written, 3 * payload_of_granules(2));

  const StoreCounters before = store->counters();
  contents(*store, cluster(1));  // a hit
  contents(*store, cluster(0));  // a read, evicting cluster 2, which is clean
  contents(*store, cluster(0));  // a hit
  const StoreCounters since = store->counters() - before;
  EXPECT_EQ(since.requests, 3u);
  EXPECT_EQ(since.reads, 1u);
  EXPECT_EQ(since.hits(), 2u);
  EXPECT_DOUBLE_EQ(since.hit_ratio(), 1 - 1.0 / 3);
  EXPECT_EQ(since.evictions, 1u);
  EXPECT_EQ(since.writes, 0u);
  EXPECT_EQ(since.bytes_read, payload_of_granules(2));
}

TEST_F(ClusterStoreTest, KindsAreCountedApart) {
  auto store = make(16);
  ASSERT_OK(store->create_record(record_id(RecordKind::kCluster, 7), filled(10, 0)));
  ASSERT_OK(store->create_record(record_id(RecordKind::kModel, 7), filled(20, 0)));
  EXPECT_EQ(store->live_bytes(RecordKind::kCluster), 10u);
  EXPECT_EQ(store->live_bytes(RecordKind::kModel), 20u);
  EXPECT_EQ(store->live_bytes(), 30u);
  ASSERT_OK(store->checkpoint({}));
  store.reset();
  store = reopen(16);
  EXPECT_EQ(store->live_bytes(RecordKind::kModel), 20u);
  const std::vector<RecordId> expected{record_id(RecordKind::kCluster, 7),
                                       record_id(RecordKind::kModel, 7)};
  EXPECT_EQ(store->record_ids(), expected);
}

TEST_F(ClusterStoreTest, RewritesReuseTheSpaceOfTwoRootsAgo) {
  auto store = make(64);
  ASSERT_OK(store->create_record(cluster(0), filled(200'000, 0)));
  // At any time two roots' extents and the ones being written: three records of 200 kB fit 1 MiB.
  for (std::uint64_t epoch = 0; epoch < 50; ++epoch) {
    (*store->edit(cluster(0))).bytes()[0] = static_cast<std::byte>(epoch);
    ASSERT_OK(store->checkpoint({}));
  }
  EXPECT_EQ(store->file_bytes(), (std::size_t{1} << 20) + 2 * kGranule);
  EXPECT_EQ(store->epoch(), 51u);
}

TEST_F(ClusterStoreTest, SmallStoresAreSmallOnDisk) {
  auto store = make(1024);
  ASSERT_OK(store->create_record(cluster(0), filled(100'000, 0)));
  ASSERT_OK(store->checkpoint({}));
  std::uint64_t bytes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(dir_)) bytes += entry.file_size();
  EXPECT_LE(bytes, (1u << 20) + 16'384u);
}

TEST_F(ClusterStoreTest, ARecordLargerThanARegularSegmentGetsItsOwn) {
  auto store = make(2048);
  const Bytes large = filled(5'000'000, 3);  // the first segment has 1 MiB
  ASSERT_OK(store->create_record(cluster(0), large));
  ASSERT_OK(store->checkpoint({}));
  store.reset();
  store = reopen(2048);
  EXPECT_EQ(contents(*store, cluster(0)), large);
}

TEST_F(ClusterStoreTest, CreateRefusesADirectoryThatHoldsAStore) {
  make(4).reset();
  const auto again = ClusterStore::create(dir_, arena_of(4));
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.status().code(), Code::kUsage);
}

TEST_F(ClusterStoreTest, OpenNamesADirectoryWithoutAStore) {
  for (const OpenMode mode : {OpenMode::kReadOnly, OpenMode::kReadWrite}) {
    const auto store = ClusterStore::open(dir_ + "/nowhere", arena_of(4), mode);
    ASSERT_FALSE(store.ok());
    EXPECT_EQ(store.status().code(), Code::kStore);
    EXPECT_EQ(store.status().file(), dir_ + "/nowhere");
  }
  EXPECT_FALSE(std::filesystem::exists(dir_ + "/nowhere"));
}

TEST_F(ClusterStoreTest, AnUnknownPolicyIsRefusedWithThoseThereAre) {
  StoreOptions options = arena_of(4);
  options.policy = "clairvoyant";
  const auto store = ClusterStore::create(dir_, options);
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().code(), Code::kUsage);
  EXPECT_NE(store.status().message().find("lru"), std::string::npos);
}

TEST_F(ClusterStoreTest, AReaderSeesTheLastCheckpointOfALiveRun) {
  auto writer = make(64);
  ASSERT_OK(writer->create_record(cluster(0), bytes_of("first")));
  ASSERT_OK(writer->checkpoint(bytes_of("1")));
  auto reader = reopen(64, OpenMode::kReadOnly);
  (*writer->edit(cluster(0))).bytes()[0] = std::byte{'F'};
  ASSERT_OK(writer->checkpoint(bytes_of("2")));
  EXPECT_EQ(contents(*reader, cluster(0)), bytes_of("first"));  // one step behind: still there
  EXPECT_EQ(copy_of(reader->state()), bytes_of("1"));
  reader = reopen(64, OpenMode::kReadOnly);
  EXPECT_EQ(contents(*reader, cluster(0)), bytes_of("First"));
}

TEST_F(ClusterStoreTest, AnOvertakenReaderIsToldSoAndNotThatTheStoreIsDamaged) {
  auto writer = make(64);
  ASSERT_OK(writer->create_record(cluster(0), filled(50'000, 0)));
  ASSERT_OK(writer->checkpoint({}));
  auto reader = reopen(64, OpenMode::kReadOnly);
  for (int i = 0; i < 5; ++i) {
    (*writer->edit(cluster(0))).bytes()[7] = static_cast<std::byte>(i);
    ASSERT_OK(writer->checkpoint({}));
  }
  const auto pin = reader->read(cluster(0));
  ASSERT_FALSE(pin.ok());
  EXPECT_NE(pin.status().cause().find("overtaken"), std::string::npos) << pin.status().message();
}

}  // namespace
}  // namespace atrium
