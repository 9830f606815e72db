// What is on disk is changed behind the store's back; every command must say what and where.
#include <cstdio>

#include "pagestore/directory.h"
#include "pagestore/disk.h"
#include "pagestore/root.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

class DamageTest : public StoreTest {
 protected:
  std::string roots() const { return dir_ + "/roots"; }
  std::string pages() const { return dir_ + "/pages.0000"; }

  static void flip(const std::string& path, std::uint64_t byte) {
    std::FILE* file = std::fopen(path.c_str(), "r+b");
    ASSERT_NE(file, nullptr);
    std::fseek(file, static_cast<long>(byte), SEEK_SET);
    const int old = std::fgetc(file);
    std::fseek(file, static_cast<long>(byte), SEEK_SET);
    std::fputc(old ^ 0x10, file);
    std::fclose(file);
  }

  Root newest_root() const {
    auto file = machine_disk(Io::kMmap).open(roots(), DiskAccess::kRead).value();
    const RootSlots slots = read_roots(*file).value();
    const bool first =
        slots[0].root && (!slots[1].root || slots[0].root->epoch > slots[1].root->epoch);
    return first ? *slots[0].root : *slots[1].root;
  }

  // Where record i's image begins in pages.0000, by the newest root's directory.
  std::uint64_t place_of(std::uint64_t i) const {
    const Root root = newest_root();
    auto file = machine_disk(Io::kMmap).open(pages(), DiskAccess::kRead).value();
    Bytes payload(root.directory.length);
    EXPECT_OK(file->read(root.directory.first * kGranule + sizeof(RecordHeader), payload));
    const std::vector<DirectoryEntry> entries = decode_directory(payload, pages()).value();
    for (const DirectoryEntry& entry : entries)
      if (entry.id == cluster(i).value) return entry.first * kGranule;
    ADD_FAILURE() << "no such record";
    return 0;
  }

  // Epoch 2 and 3: record 0 differs between them, record 1 does not. Closed again.
  void make_two_epochs() {
    auto store = make(16);
    ASSERT_OK(store->create_record(cluster(0), bytes_of("of epoch 2")));
    ASSERT_OK(store->create_record(cluster(1), filled(9000, 1)));
    ASSERT_OK(store->checkpoint(bytes_of("state 2")));
    (*store->edit(cluster(0))).bytes()[9] = std::byte{'3'};
    ASSERT_OK(store->checkpoint(bytes_of("state 3")));
  }

  // The store opens, and verify_all fails with an error at `place`.
  void expect_fault_at(const std::string& place) {
    auto store = reopen(16, OpenMode::kReadOnly);
    const Status status = store->verify_all();
    EXPECT_EQ(status.code(), Code::kStore);
    EXPECT_NE(status.place().find(place), std::string::npos) << status.message();
    EXPECT_EQ(status.file(), pages());
    EXPECT_FALSE(status.remedy().empty());
  }

  // Opening to read fails; opening to go on falls back on epoch 2 and says so.
  void expect_fall_back(const std::string& file, const std::string& place) {
    const auto reader = ClusterStore::open(dir_, arena_of(16), OpenMode::kReadOnly);
    ASSERT_FALSE(reader.ok());
    EXPECT_EQ(reader.status().code(), Code::kStore);
    EXPECT_EQ(reader.status().file(), file);
    EXPECT_NE(reader.status().place().find(place), std::string::npos) << reader.status().message();
    EXPECT_FALSE(ClusterStore::open(dir_, arena_of(16), OpenMode::kReadWrite).ok());
    auto store = reopen(16, OpenMode::kRecover);
    EXPECT_NE(store->recovery_note().message().find("epoch 2"), std::string::npos)
        << store->recovery_note().message();
    EXPECT_EQ(copy_of(store->state()), bytes_of("state 2"));
    EXPECT_EQ(contents(*store, cluster(0)), bytes_of("of epoch 2"));
    EXPECT_EQ(contents(*store, cluster(1)), filled(9000, 1));
    EXPECT_OK(store->verify_all());  // whole again
    store.reset();
    store = reopen(16, OpenMode::kReadOnly);
    EXPECT_TRUE(store->recovery_note().ok());
    EXPECT_OK(store->verify_all());
    EXPECT_EQ(contents(*store, cluster(0)), bytes_of("of epoch 2"));
  }
};

TEST_F(DamageTest, NothingIsWrongWithAStoreThatNobodyTouched) {
  make_two_epochs();
  auto store = reopen(16, OpenMode::kReadOnly);
  EXPECT_OK(store->verify_all());
  EXPECT_EQ(copy_of(store->state()), bytes_of("state 3"));
  EXPECT_EQ(contents(*store, cluster(0)), bytes_of("of epoch 3"));
}

TEST_F(DamageTest, ABitFlippedInAPayloadIsNamedByItsRecord) {
  make_two_epochs();
  flip(pages(), place_of(1) + sizeof(RecordHeader) + 5000);
  expect_fault_at("cluster 1");
  auto store = reopen(16);
  const auto pin = store->read(cluster(1));
  ASSERT_FALSE(pin.ok());
  EXPECT_NE(pin.status().message().find("cluster 1"), std::string::npos);
  EXPECT_EQ(store->arena_used_bytes(), 0u);  // nothing of it stays in the arena
  EXPECT_EQ(contents(*store, cluster(0)), bytes_of("of epoch 3"));  // the others can be read
}

TEST_F(DamageTest, ABitFlippedInAHeaderIsNamedByItsRecord) {
  make_two_epochs();
  flip(pages(), place_of(0) + offsetof(RecordHeader, length));
  expect_fault_at("cluster 0");
}

TEST_F(DamageTest, ABitFlippedInWhatOnlyTheOlderRootNamesIsFoundByVerification) {
  make_two_epochs();
  const Root newest = newest_root();
  const std::uint64_t older_slot = (newest.epoch - 1) & 1;
  auto file = machine_disk(Io::kMmap).open(roots(), DiskAccess::kRead).value();
  const Root older = *read_roots(*file).value()[older_slot].root;
  flip(pages(), older.state.first * kGranule + sizeof(RecordHeader));
  expect_fault_at("directory 1");
}

TEST_F(DamageTest, AFlippedDirectoryFallsBackOnTheOlderRoot) {
  make_two_epochs();
  flip(pages(), newest_root().directory.first * kGranule + sizeof(RecordHeader) + 3);
  expect_fall_back(pages(), "directory 0");
}

TEST_F(DamageTest, AFlippedStateFallsBackOnTheOlderRoot) {
  make_two_epochs();
  flip(pages(), newest_root().state.first * kGranule + sizeof(RecordHeader) + 3);
  expect_fall_back(pages(), "directory 1");
}

TEST_F(DamageTest, ATornRootFallsBackOnTheOlderOne) {
  make_two_epochs();
  const std::size_t slot = slot_of(3);
  flip(roots(), slot * kGranule + 40);
  expect_fall_back(roots(), "root slot 1");
}

TEST_F(DamageTest, TwoFaultyRootsAreAnErrorAndNothingIsWritten) {
  make_two_epochs();
  flip(roots(), 40);
  flip(roots(), kGranule + 40);
  const auto store = ClusterStore::open(dir_, arena_of(16), OpenMode::kRecover);
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().code(), Code::kStore);
  EXPECT_EQ(store.status().file(), roots());
  // And create does not take the ruins for a store whose making was cut short.
  EXPECT_EQ(ClusterStore::create(dir_, arena_of(16)).status().code(), Code::kUsage);
}

TEST_F(DamageTest, APageFileThatEndsEarlyIsNamed) {
  make_two_epochs();
  std::filesystem::resize_file(pages(), 2 * kGranule);
  const auto store = ClusterStore::open(dir_, arena_of(16), OpenMode::kReadOnly);
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().code(), Code::kStore);
  EXPECT_EQ(store.status().file(), pages());
}

TEST_F(DamageTest, APageFileCutShortWhileItIsMappedIsAnErrorAndNotASignal) {
  make_two_epochs();
  auto store = reopen(16, OpenMode::kReadOnly);
  ASSERT_EQ(contents(*store, cluster(0)), bytes_of("of epoch 3"));  // mapped now
  std::filesystem::resize_file(pages(), kGranule);
  const auto pin = store->read(cluster(1));
  ASSERT_FALSE(pin.ok());
  EXPECT_EQ(pin.status().code(), Code::kStore);
  EXPECT_EQ(pin.status().file(), pages());
}

TEST_F(DamageTest, AMissingPageFileIsNamed) {
  make_two_epochs();
  std::filesystem::remove(pages());
  const auto store = ClusterStore::open(dir_, arena_of(16), OpenMode::kReadOnly);
  ASSERT_FALSE(store.ok());
  EXPECT_EQ(store.status().file(), pages());
}

TEST_F(DamageTest, ARecordOfAnotherStoreIsNotTakenForOurs) {
  make_two_epochs();
  const std::string theirs = dir_ + "/other";
  {
    auto other = ClusterStore::create(theirs, arena_of(16)).value();
    ASSERT_OK(other->create_record(cluster(0), bytes_of("of epoch 2")));
    ASSERT_OK(other->create_record(cluster(1), filled(9000, 1)));
    ASSERT_OK(other->checkpoint(bytes_of("state 2")));
    (*other->edit(cluster(0))).bytes()[9] = std::byte{'3'};
    ASSERT_OK(other->checkpoint(bytes_of("state 3")));
  }
  std::filesystem::copy_file(theirs + "/pages.0000", pages(),
                             std::filesystem::copy_options::overwrite_existing);
  const auto store = ClusterStore::open(dir_, arena_of(16), OpenMode::kReadOnly);
  ASSERT_FALSE(store.ok());
  EXPECT_NE(store.status().cause().find("another store"), std::string::npos)
      << store.status().message();
}

}  // namespace
}  // namespace atrium
