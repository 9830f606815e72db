// What one would write first: records one after another in a file, pread with O_DIRECT into an
// arena with LRU. No index is needed, since sizes are known, and nothing is kept for a crash.
#include <list>

#include "bench/contender.h"
#include "pagestore/arena.h"
#include "pagestore/cluster_store.h"
#include "pagestore/disk.h"

namespace atrium {

namespace {

std::uint64_t granules_for(std::size_t bytes) { return (bytes + kGranule - 1) / kGranule; }

class PreadContender final : public Contender {
 public:
  PreadContender(std::unique_ptr<DiskFile> file, std::unique_ptr<Arena> arena)
      : file_(std::move(file)), arena_(std::move(arena)), records_(kRecords) {
    std::uint64_t next = 0;
    for (RecordIndex i = 0; i < kRecords; ++i) {
      records_[i] = {.first = next, .granules = granules_for(record_sizes()[i])};
      next += records_[i].granules;
    }
    file_bytes_ = next * kGranule;
  }

  std::uint64_t file_bytes() const { return file_bytes_; }

  Result<std::span<const std::byte>> read(RecordIndex index) override {
    Record& record = records_[index];
    ++requests_;
    if (record.slot == kNoGranule) {
      ATRIUM_RETURN_IF_ERROR(bring_in(index));
    } else {
      ++hits_;
      recent_.splice(recent_.end(), recent_, record.place);
    }
    return payload(index);
  }

  Status write(RecordIndex index, std::span<const std::byte> bytes) override {
    std::vector<std::byte> image(records_[index].granules * kGranule);
    std::ranges::copy(bytes, image.begin());
    return write_all(*file_, records_[index].first * kGranule, image);
  }

  Status commit() override { return file_->sync(); }

  std::optional<double> hit_ratio() const override {
    return static_cast<double>(hits_) / static_cast<double>(requests_);
  }

 private:
  struct Record {
    std::uint64_t first = 0, granules = 0;  // in the file
    std::uint64_t slot = kNoGranule;        // in the arena
    std::list<RecordIndex>::iterator place{};
  };

  std::span<const std::byte> payload(RecordIndex index) const {
    const Record& record = records_[index];
    return arena_->image(record.slot, record.granules).first(record_sizes()[index]);
  }

  Status bring_in(RecordIndex index) {
    Record& record = records_[index];
    auto slot = arena_->allocate(record.granules);
    for (; !slot; slot = arena_->allocate(record.granules)) evict_one();
    ATRIUM_RETURN_IF_ERROR(
        file_->read(record.first * kGranule, arena_->image(*slot, record.granules)));
    record.slot = *slot;
    record.place = recent_.insert(recent_.end(), index);
    return is_whole(payload(index)) ? Status() : not_whole(file_->path(), index);
  }

  void evict_one() {
    Record& victim = records_[recent_.front()];
    recent_.pop_front();
    arena_->free(victim.slot, victim.granules);
    victim.slot = kNoGranule;
  }

  std::unique_ptr<DiskFile> file_;
  std::unique_ptr<Arena> arena_;
  std::vector<Record> records_;
  std::list<RecordIndex> recent_;  // the one used longest ago in front
  std::uint64_t file_bytes_ = 0, requests_ = 0, hits_ = 0;
};

Result<std::unique_ptr<Contender>> open_pread(const std::string& dir, Purpose purpose) {
  Disk& disk = machine_disk(Io::kDirect);
  ATRIUM_RETURN_IF_ERROR(disk.make_directory(dir));
  const bool make = purpose == Purpose::kMake;
  auto file = disk.open(dir + "/records", make ? DiskAccess::kReadWrite : DiskAccess::kRead);
  if (!file.ok()) return file.status();
  auto arena = Arena::make(ClusterStore::arena_memory(kArenaBytes));  // as much as ours takes
  if (!arena.ok()) return arena.status();
  DiskFile& opened = **file;
  auto contender =
      std::make_unique<PreadContender>(std::move(file).value(), std::move(arena).value());
  if (make) ATRIUM_RETURN_IF_ERROR(opened.allocate(contender->file_bytes()));
  return std::unique_ptr<Contender>(std::move(contender));
}

}  // namespace

ContenderKind pread_contender() {
  return {"pread", "pread", false, "pread, O_DIRECT, into an arena, LRU", open_pread};
}

}  // namespace atrium
