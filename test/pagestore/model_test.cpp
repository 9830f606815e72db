// The store against a model of it: contents kept outside, and an LRU cache with write-back
// that counts granules, written as plainly as possible. Every count and every byte must agree.
#include <algorithm>
#include <list>
#include <map>
#include <set>

#include "pagestore/directory.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {
namespace {

class ModelStore {
 public:
  explicit ModelStore(std::size_t granules) : capacity_(granules) {}

  bool read(std::uint64_t id) {  // false: refused
    if (!in_arena_.contains(id)) {
      if (!place(id, granules(id))) return false;
      ++reads;
    }
    lru_.remove(id);
    ++pins_[id];
    ++requests;
    return true;
  }
  void release(std::uint64_t id) {
    if (--pins_[id] == 0) lru_.push_back(id);
  }
  bool edit(std::uint64_t id) {
    if (!read(id)) return false;
    dirty_.insert(id);
    return true;
  }
  bool resize(std::uint64_t id, std::size_t size) {
    const std::size_t wanted = granules_of(size);
    if (wanted + pinned() - granules(id) > capacity_) return false;
    while (used() - granules(id) + wanted > capacity_) evict();
    content[id].resize(size);
    return true;
  }
  bool create(std::uint64_t id, const Bytes& bytes) {
    content[id] = bytes;
    if (!place(id, granules(id))) {
      content.erase(id);
      return false;
    }
    dirty_.insert(id);
    lru_.push_back(id);
    return true;
  }
  void checkpoint() {
    writes += dirty_.size();
    checkpoint_writes += dirty_.size();
    dirty_.clear();
    durable = content;
  }
  void reopen() {
    content = durable;
    in_arena_.clear();
    lru_.clear();
    dirty_.clear();
    pins_.clear();
    requests = reads = writes = checkpoint_writes = evictions = 0;
  }

  std::map<std::uint64_t, Bytes> content, durable;
  std::uint64_t requests = 0, reads = 0, writes = 0, checkpoint_writes = 0, evictions = 0;

 private:
  std::size_t granules(std::uint64_t id) const { return granules_of(content.at(id).size()); }
  std::size_t used() const {
    std::size_t n = 0;
    for (const std::uint64_t id : in_arena_) n += granules(id);
    return n;
  }
  std::size_t pinned() const {
    std::size_t n = 0;
    for (const auto& [id, count] : pins_)
      if (count > 0) n += granules(id);
    return n;
  }
  bool place(std::uint64_t id, std::size_t n) {
    if (n + pinned() > capacity_) return false;
    while (used() + n > capacity_) evict();
    in_arena_.insert(id);
    return true;
  }
  void evict() {
    const std::uint64_t victim = lru_.front();
    lru_.pop_front();
    writes += dirty_.erase(victim);
    in_arena_.erase(victim);
    ++evictions;
  }

  std::size_t capacity_;
  std::set<std::uint64_t> in_arena_;
  std::map<std::uint64_t, int> pins_;
  std::list<std::uint64_t> lru_;
  std::set<std::uint64_t> dirty_;
};

class ModelTest : public StoreTest {
 protected:
  static void expect_same_counts(const StoreCounters& counters, const ModelStore& model) {
    ASSERT_EQ(counters.requests, model.requests);
    ASSERT_EQ(counters.reads, model.reads);
    ASSERT_EQ(counters.writes, model.writes);
    ASSERT_EQ(counters.checkpoint_writes, model.checkpoint_writes);
    ASSERT_EQ(counters.evictions, model.evictions);
    ASSERT_EQ(counters.fragmentation_evictions, 0u);
  }
};

TEST_F(ModelTest, RandomReadsEditsGrowthPinsCheckpointsAndReopenings) {
  constexpr std::size_t kArena = 64;      // granules
  constexpr std::uint64_t kRecords = 60;  // of 1 to 8 granules: some five times the arena
  constexpr std::size_t kMaxBytes = 30'000;
  constexpr std::size_t kMaxPins = 16;
  std::mt19937_64 random(2);
  ModelStore model(kArena);
  auto store = make(kArena);
  std::vector<ClusterPin> pins;
  std::uint64_t refused = 0;

  for (int step = 0; step < 6000; ++step) {
    const std::uint64_t id = random() % kRecords;
    const std::uint64_t what = random() % 1000;
    if (!model.content.contains(id)) {
      const Bytes bytes = filled(random() % kMaxBytes, random());
      const bool fits = model.create(id, bytes);
      ASSERT_EQ(store->create_record(cluster(id), bytes).ok(), fits);
      refused += fits ? 0 : 1;
    } else if (what < 500) {  // read and hold
      const bool fits = model.read(id);
      auto pin = store->read(cluster(id));
      ASSERT_EQ(pin.ok(), fits);
      if (!fits) {
        ASSERT_EQ(pin.status().code(), Code::kUsage);
        ++refused;
        continue;
      }
      ASSERT_EQ(copy_of((*pin).bytes()), model.content[id]);
      pins.push_back(std::move(pin).value());
    } else if (what < 990) {  // change, and perhaps resize
      const bool held =
          std::ranges::any_of(pins, [&](const ClusterPin& p) { return p.id() == cluster(id); });
      const bool fits = model.edit(id);
      auto edit = store->edit(cluster(id));
      ASSERT_EQ(edit.ok(), fits);
      if (!fits) continue;
      if (!held && what < 800) {
        const std::size_t size = random() % kMaxBytes;
        const bool resized = model.resize(id, size);
        ASSERT_EQ(edit->resize(size).ok(), resized);
        refused += resized ? 0 : 1;
      }
      ASSERT_EQ(copy_of(edit->bytes()), model.content[id]);
      if (!model.content[id].empty()) {
        const std::size_t at = random() % model.content[id].size();
        model.content[id][at] = edit->bytes()[at] = static_cast<std::byte>(random());
      }
      model.release(id);
    } else if (what < 996) {
      model.checkpoint();
      ASSERT_OK(store->checkpoint({}));
    } else {
      for (const ClusterPin& pin : pins) model.release(index_of(pin.id()));
      pins.clear();
      store.reset();
      store = reopen(kArena);
      model.reopen();
    }
    while (pins.size() > random() % (kMaxPins + 1)) {
      const std::size_t i = random() % pins.size();
      ASSERT_EQ(copy_of(pins[i].bytes()), model.content[index_of(pins[i].id())]);
      model.release(index_of(pins[i].id()));
      pins.erase(pins.begin() + static_cast<std::ptrdiff_t>(i));
    }
    expect_same_counts(store->counters(), model);
    ASSERT_LE(store->arena_used_bytes(), kArena * kGranule);
  }
  EXPECT_GT(refused, 0u);  // the tight cases were reached
  pins.clear();
  ASSERT_OK(store->checkpoint({}));
  EXPECT_OK(store->verify_all());
  for (const auto& [id, bytes] : model.content) EXPECT_EQ(contents(*store, cluster(id)), bytes);
}

// Records of one size: the textbook's LRU over ids, with dirty bits, is all there is to it.
TEST_F(ModelTest, EqualSizesCountAsTextbookLru) {
  constexpr std::size_t kSlots = 10;
  constexpr std::uint64_t kRecords = 25;
  auto store = make(kSlots);
  for (std::uint64_t id = 0; id < kRecords; ++id)
    ASSERT_OK(store->create_record(cluster(id), filled(4000, id)));
  ASSERT_OK(store->checkpoint({}));

  std::list<std::uint64_t> recent;  // what creation left
  for (std::uint64_t id = kRecords - kSlots; id < kRecords; ++id) recent.push_front(id);
  std::set<std::uint64_t> dirty;
  std::uint64_t misses = 0, writebacks = 0;
  std::mt19937_64 random(4);
  const StoreCounters before = store->counters();
  constexpr std::uint64_t kRequests = 3000;
  for (std::uint64_t n = 0; n < kRequests; ++n) {
    const std::uint64_t id = std::min(random() % kRecords, random() % kRecords);
    if (std::ranges::find(recent, id) == recent.end()) {
      ++misses;
      writebacks += dirty.erase(recent.back());
      recent.pop_back();
    }
    recent.remove(id);
    recent.push_front(id);
    if (n % 3 == 0) {
      ASSERT_TRUE(store->edit(cluster(id)).ok());
      dirty.insert(id);
    } else {
      ASSERT_TRUE(store->read(cluster(id)).ok());
    }
  }
  ASSERT_OK(store->checkpoint({}));
  const StoreCounters since = store->counters() - before;
  EXPECT_EQ(since.requests, kRequests);
  EXPECT_EQ(since.reads, misses);
  EXPECT_EQ(since.writes - since.checkpoint_writes, writebacks);
  EXPECT_EQ(since.checkpoint_writes, dirty.size());
  EXPECT_EQ(since.fragmentation_evictions, 0u);
}

}  // namespace
}  // namespace atrium
