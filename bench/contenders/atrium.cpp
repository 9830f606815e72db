// The project's own page store, through its public interface, told the schedule ahead.
#include <algorithm>

#include "bench/contender.h"
#include "pagestore/cluster_store.h"

namespace atrium {

namespace {

RecordId id_of(RecordIndex record) { return record_id(RecordKind::kCluster, record); }

class AtriumContender final : public Contender {
 public:
  explicit AtriumContender(std::unique_ptr<ClusterStore> store) : store_(std::move(store)) {}

  void foresee(std::span<const RecordIndex> reads) override {
    std::vector<RecordId> ids(reads.size());
    std::ranges::transform(reads, ids.begin(), id_of);
    store_->foresee(ids);
  }

  Result<std::span<const std::byte>> read(RecordIndex record) override {
    pin_ = {};
    auto pin = store_->read(id_of(record));  // checks by XXH3 what it brings in
    if (!pin.ok()) return pin.status();
    pin_ = std::move(pin).value();
    return pin_.bytes();
  }

  Status write(RecordIndex record, std::span<const std::byte> payload) override {
    pin_ = {};
    if (!store_->contains(id_of(record))) return store_->create_record(id_of(record), payload);
    auto edit = store_->edit(id_of(record));
    if (!edit.ok()) return edit.status();
    ATRIUM_RETURN_IF_ERROR((*edit).resize(payload.size()));
    std::ranges::copy(payload, (*edit).bytes().begin());
    return {};
  }

  Status commit() override {
    pin_ = {};
    return store_->checkpoint({});
  }

  std::optional<double> hit_ratio() const override { return store_->counters().hit_ratio(); }

 private:
  std::unique_ptr<ClusterStore> store_;
  ClusterPin pin_;  // gone before its store
};

template <Io io>
Result<std::unique_ptr<Contender>> open_with(const std::string& dir, Purpose purpose,
                                             const char* policy) {
  const StoreOptions options{.arena_bytes = kArenaBytes, .policy = policy, .io = io};
  auto store = purpose == Purpose::kRead ? ClusterStore::open(dir, options, OpenMode::kReadOnly)
                                         : ClusterStore::create(dir, options);
  if (!store.ok()) return store.status();
  return std::unique_ptr<Contender>(std::make_unique<AtriumContender>(std::move(store).value()));
}

template <Io io>
Result<std::unique_ptr<Contender>> open_lru(const std::string& dir, Purpose purpose) {
  return open_with<io>(dir, purpose, "lru");
}

template <Io io>
Result<std::unique_ptr<Contender>> open_belady(const std::string& dir, Purpose purpose) {
  return open_with<io>(dir, purpose, "belady");
}

}  // namespace

std::vector<ContenderKind> atrium_contenders() {
  return {
      {"mmap-lru", "atrium", true, "ours, `--io mmap`, LRU", open_lru<Io::kMmap>},
      {"mmap-belady", "atrium", false, "ours, `--io mmap`, farthest next use",
       open_belady<Io::kMmap>},
      {"direct-lru", "atrium", true, "ours, `--io direct`, LRU", open_lru<Io::kDirect>},
      {"direct-belady", "atrium", false, "ours, `--io direct`, farthest next use",
       open_belady<Io::kDirect>},
  };
}

}  // namespace atrium
