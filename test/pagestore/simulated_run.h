// A random run of a store on a simulated disk, with the contents that it should have kept outside.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <random>

#include "test/pagestore/simulated_disk.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {

struct Snapshot {
  std::map<std::uint64_t, Bytes> records;
  Bytes state;
  bool operator==(const Snapshot&) const = default;
};

class SimulatedRun {
 public:
  static constexpr std::size_t kArenaGranules = 8;
  static constexpr std::uint64_t kRecords = 12;
  // Records of three granules at most; with every other seed of seven, which is nearly the arena.
  static constexpr std::size_t kMaxBytes = 12'000, kMaxBytesOfLarge = 28'000;

  SimulatedRun(SimulatedDisk& disk, std::uint64_t seed)
      : disk_(disk), random_(seed), max_bytes_(seed % 2 == 0 ? kMaxBytesOfLarge : kMaxBytes) {}

  static StoreOptions options(SimulatedDisk& disk) {
    return {.arena_bytes = kArenaGranules * kGranule, .policy = "lru", .disk = &disk};
  }

  Status create() {
    attempted.assign(1, Snapshot{});
    auto store = ClusterStore::create("run", options(disk_));
    if (!store.ok()) return store.status();
    adopt(std::move(store).value(), Snapshot{});
    return {};
  }

  void adopt(std::unique_ptr<ClusterStore> store, const Snapshot& snapshot) {
    store_ = std::move(store);
    now_ = snapshot;
    kept = snapshot;
    attempted.clear();
  }

  // One random call; what it did is remembered only if it succeeded.
  Status step() {
    const std::uint64_t id = random_() % kRecords;
    const std::uint64_t what = random_() % 12;
    if (what == 0) return checkpoint();
    if (what >= 10 && random_() % 2 == 0) return past_the_arena(kRecords + id);
    if (what == 11) foresee();
    if (!now_.records.contains(id)) return create_record(id);
    return what < 4 || what == 11 ? read(id) : change(id, what < 7);
  }

  Status checkpoint() {
    now_.state = filled(random_() % 500, random_());
    attempted.push_back(now_);
    ATRIUM_RETURN_IF_ERROR(store_->checkpoint(now_.state));
    kept = now_;
    attempted.clear();
    return {};
  }

  Status read_everything() {
    for (const auto& [id, bytes] : now_.records)
      if (id < kRecords) ATRIUM_RETURN_IF_ERROR(read(id));
    return {};
  }

  ClusterStore& store() { return *store_; }
  void close() { store_.reset(); }

  // May a store that was opened afterwards hold this?
  bool may_hold(const Snapshot& found) const {
    return (kept.has_value() && found == *kept) ||
           std::ranges::find(attempted, found) != attempted.end();
  }

  std::optional<Snapshot> kept;     // the last checkpoint that succeeded
  std::vector<Snapshot> attempted;  // those after it that failed: one may have reached the disk

 private:
  Status create_record(std::uint64_t id) {
    const Bytes bytes = filled(random_() % max_bytes_, random_());
    ATRIUM_RETURN_IF_ERROR(store_->create_record(cluster(id), bytes));
    now_.records[id] = bytes;
    return {};
  }

  // A record that is streamed, dropped, and made again in the arena under the number it had.
  Status past_the_arena(std::uint64_t id) {
    const std::uint64_t what = random_() % 4;
    if (!now_.records.contains(id)) return what == 0 ? create_record(id) : stream_out(id);
    if (store_->in_arena(cluster(id))) return what == 0 ? change(id, true) : read(id);
    if (what == 0) return read(id);
    if (what == 1) return stream_in(id);
    if (what == 2) return stream_out(id);
    store_->drop_streamed(cluster(id));
    now_.records.erase(id);
    return {};
  }

  Status stream_in(std::uint64_t id) {
    const auto bytes = store_->stream_in(cluster(id));
    if (!bytes.ok()) return bytes.status();
    EXPECT_EQ(copy_of(*bytes), now_.records[id]);
    return {};
  }

  Status stream_out(std::uint64_t id) {
    const Bytes bytes = filled(random_() % max_bytes_, random_());
    ATRIUM_RETURN_IF_ERROR(store_->stream_out(cluster(id), bytes));
    now_.records[id] = bytes;
    return {};
  }

  // Of what comes some is foreseen, and some of that comes otherwise.
  void foresee() {
    std::vector<RecordId> next;
    for (int i = 0; i < 4; ++i) {
      const std::uint64_t id = random_() % kRecords;
      if (now_.records.contains(id)) next.push_back(cluster(id));
    }
    store_->foresee(next);
  }

  Status read(std::uint64_t id) {
    const auto pin = store_->read(cluster(id));
    if (!pin.ok()) return pin.status();
    EXPECT_EQ(copy_of((*pin).bytes()), now_.records[id]);
    return {};
  }

  Status change(std::uint64_t id, bool resize) {
    auto edit = store_->edit(cluster(id));
    if (!edit.ok()) return edit.status();
    Bytes& expected = now_.records[id];
    EXPECT_EQ(copy_of(edit->bytes()), expected);
    if (resize) {
      const std::size_t size = random_() % max_bytes_;
      ATRIUM_RETURN_IF_ERROR(edit->resize(size));
      expected.resize(size);
    }
    const std::uint64_t seed = random_();
    expected = filled(expected.size(), seed);
    std::ranges::copy(expected, edit->bytes().begin());
    return {};
  }

  SimulatedDisk& disk_;
  std::mt19937_64 random_;
  std::size_t max_bytes_;
  std::unique_ptr<ClusterStore> store_;
  Snapshot now_;
};

// All of a store as it was last made durable.
inline Snapshot snapshot_of(ClusterStore& store) {
  Snapshot snapshot;
  for (const RecordId id : store.record_ids())
    snapshot.records[index_of(id)] = index_of(id) < SimulatedRun::kRecords
                                         ? contents(store, id)
                                         : copy_of(store.stream_in(id).value());
  snapshot.state = copy_of(store.state());
  return snapshot;
}

}  // namespace atrium
