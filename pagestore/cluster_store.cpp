#include "pagestore/cluster_store.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/check.h"
#include "pagestore/arena.h"
#include "pagestore/disk.h"
#include "pagestore/io_clock.h"
#include "pagestore/page_file.h"
#include "pagestore/policy.h"
#include "pagestore/root.h"

namespace atrium {

// A record in the arena is in one of these states; bytes are trusted in all but the first.
//
//              bring_in, checked          edit
//     absent ────────────────▶ clean ──────────────▶ dirty ◀── create_record
//       ▲                        │ ▲    write_back      │
//       └──────── evict ─────────┘ └────────────────────┘
//
// absent: the extent on disk is the record. clean: extent and image are equal. dirty: the image is
// the record, and the extent, if there is one, is what the last root knows. Pinned ones stay.

namespace {

// What root e names is only reused when root e + 2 is durable.
constexpr std::uint64_t kStepsToReuse = 2;

std::size_t kind_index(RecordId id) {
  const auto kind = static_cast<std::size_t>(kind_of(id));
  ATRIUM_CHECK(kind < kRecordKinds);
  return kind;
}

}  // namespace

StoreCounters StoreCounters::operator-(const StoreCounters& before) const {
  return {.requests = requests - before.requests,
          .reads = reads - before.reads,
          .writes = writes - before.writes,
          .bytes_read = bytes_read - before.bytes_read,
          .bytes_written = bytes_written - before.bytes_written,
          .checkpoint_writes = checkpoint_writes - before.checkpoint_writes,
          .checkpoint_bytes = checkpoint_bytes - before.checkpoint_bytes,
          .evictions = evictions - before.evictions,
          .fragmentation_evictions = fragmentation_evictions - before.fragmentation_evictions,
          .checkpoints = checkpoints - before.checkpoints,
          .overhead_bytes = overhead_bytes - before.overhead_bytes,
          .io_seconds = io_seconds - before.io_seconds};
}

ClusterPin::ClusterPin(ClusterStore& store, StoredRecord& record)
    : store_(&store), record_(&record), id_(record.id), bytes_(store.payload_of(record)) {}

ClusterPin::~ClusterPin() {
  if (store_ != nullptr) store_->release(*record_);
}

void ClusterPin::swap(ClusterPin& other) noexcept {
  std::swap(store_, other.store_);
  std::swap(record_, other.record_);
  std::swap(id_, other.id_);
  std::swap(bytes_, other.bytes_);
}

ClusterEdit::ClusterEdit(ClusterStore& store, StoredRecord& record)
    : store_(&store), record_(&record), id_(record.id), bytes_(store.payload_of(record)) {
  record.dirty = true;
  ++store.edits_;
}

ClusterEdit::~ClusterEdit() {
  if (store_ == nullptr) return;
  --store_->edits_;
  store_->release(*record_);
}

void ClusterEdit::swap(ClusterEdit& other) noexcept {
  std::swap(store_, other.store_);
  std::swap(record_, other.record_);
  std::swap(id_, other.id_);
  std::swap(bytes_, other.bytes_);
}

Status ClusterEdit::resize(std::size_t size) {
  ATRIUM_CHECK(store_ != nullptr && record_->pins == 1);
  ATRIUM_RETURN_IF_ERROR(store_->resize(*record_, size));
  bytes_ = store_->payload_of(*record_);
  return {};
}

ClusterStore::ClusterStore(const std::string& dir, const StoreOptions& options, OpenMode mode)
    : dir_(dir),
      mode_(mode),
      disk_(options.disk != nullptr ? *options.disk : machine_disk(options.io)) {}

ClusterStore::~ClusterStore() { ATRIUM_CHECK(pinned_bytes_ == 0); }

std::span<std::byte> ClusterStore::image_of(const StoredRecord& record) const {
  return arena_->image(record.slot, record.granules());
}

std::span<std::byte> ClusterStore::payload_of(const StoredRecord& record) const {
  return image_of(record).subspan(sizeof(RecordHeader), record.length);
}

void ClusterStore::count_pinned(std::uint64_t granules) {
  pinned_bytes_ += granules * kGranule;
  pinned_peak_bytes_ = std::max(pinned_peak_bytes_, pinned_bytes_);
}

Result<ClusterPin> ClusterStore::read(RecordId id) {
  auto record = pin(id);
  if (!record.ok()) return record.status();
  return ClusterPin(*this, **record);
}

Result<ClusterEdit> ClusterStore::edit(RecordId id) {
  ATRIUM_CHECK(mode_ == OpenMode::kReadWrite);
  auto record = pin(id);
  if (!record.ok()) return record.status();
  return ClusterEdit(*this, **record);
}

StoredRecord& ClusterStore::add_record(StoredRecord record) {
  record.number = static_cast<RecordNumber>(by_number_.size());
  StoredRecord& added = records_.emplace(record.id, record).first->second;
  by_number_.push_back(&added);
  return added;
}

Result<StoredRecord*> ClusterStore::pin(RecordId id) {
  const auto found = records_.find(id);
  ATRIUM_CHECK(found != records_.end());
  StoredRecord& record = found->second;
  if (record.resident())
    policy_->on_hit(record.number);
  else
    ATRIUM_RETURN_IF_ERROR(bring_in(record));
  ++counters_.requests;
  if (record.pins++ == 0) count_pinned(record.granules());
  return &record;
}

void ClusterStore::release(StoredRecord& record) {
  ATRIUM_CHECK(record.pins > 0);
  if (--record.pins > 0) return;
  pinned_bytes_ -= record.granules() * kGranule;
  policy_->on_release(record.number);
}

Status ClusterStore::bring_in(StoredRecord& record) {
  policy_->on_miss(record.number, record.granules() * kGranule);
  const auto slot = make_room(record.id, record.granules());
  if (!slot.ok()) return slot.status();
  const auto image = arena_->image(*slot, record.granules());
  const Status status = read_image(image, record.id, record.on_disk, uuid_);
  if (!status.ok()) {
    arena_->free(*slot, record.granules());
    return status;
  }
  record.slot = *slot;
  policy_->on_insert(record.number, image.size());
  ++counters_.reads;
  counters_.bytes_read += record.length;
  return {};
}

Status ClusterStore::create_record(RecordId id, std::span<const std::byte> payload) {
  ATRIUM_CHECK(mode_ == OpenMode::kReadWrite && !contains(id));
  ATRIUM_CHECK(kind_of(id) != RecordKind::kDirectory);
  StoredRecord record;
  record.id = id;
  record.length = payload.size();
  record.dirty = true;
  const auto slot = make_room(id, record.granules());
  if (!slot.ok()) return slot.status();
  record.slot = *slot;
  std::ranges::copy(payload, payload_of(record).begin());
  live_bytes_[kind_index(id)] += payload.size();
  const RecordNumber number = add_record(record).number;
  policy_->on_insert(number, arena_cost(payload.size()));
  policy_->on_release(number);
  return {};
}

// Can the arena hold this beside what is pinned, at best? own_granules: what the record has of the
// pinned ones already.
Status ClusterStore::fits(RecordId id, std::uint64_t granules, std::uint64_t own_granules) const {
  const std::uint64_t others = pinned_bytes_ / kGranule - own_granules;
  if (granules + others <= arena_->granules()) return {};
  return Status(
      Code::kUsage, dir_, to_string(id),
      "arena too small: it takes " + std::to_string(granules * kGranule) + " bytes beside " +
          std::to_string(others * kGranule) + " pinned, of " + std::to_string(arena_bytes()),
      "give an arena of at least " + std::to_string((granules + others) * kGranule) + " bytes");
}

Result<std::uint64_t> ClusterStore::make_room(RecordId id, std::uint64_t granules) {
  ATRIUM_RETURN_IF_ERROR(fits(id, granules, 0));
  for (;;) {
    if (const auto slot = arena_->allocate(granules)) return *slot;
    ATRIUM_RETURN_IF_ERROR(evict_one(id, granules, 0));
  }
}

// Makes room, in the policy's order, for a record that found no hole of its size.
Status ClusterStore::evict_one(RecordId id, std::uint64_t granules, std::uint64_t own_granules) {
  const auto victim = policy_->victim(counters_.requests);
  if (!victim)
    return Status(Code::kUsage, dir_, to_string(id),
                  "arena too small: " + std::to_string(arena_->free_granules() * kGranule) +
                      " bytes are free, but pinned records part them, and it takes " +
                      std::to_string(granules * kGranule) + " in one piece",
                  "give an arena of at least " +
                      std::to_string((arena_->granules() + granules) * kGranule) + " bytes");
  StoredRecord& record = *by_number_[*victim];
  ATRIUM_CHECK(record.resident() && record.pins == 0);
  const bool room_in_pieces = arena_->free_granules() + own_granules >= granules;
  if (record.dirty) ATRIUM_RETURN_IF_ERROR(write_back(record));
  arena_->free(record.slot, record.granules());
  record.slot = kNoGranule;
  policy_->on_evict(record.number);
  ++counters_.evictions;
  counters_.fragmentation_evictions += room_in_pieces ? 1 : 0;
  return {};
}

Status ClusterStore::resize(StoredRecord& record, std::size_t size) {
  const std::uint64_t old_length = record.length;
  const std::uint64_t old_granules = record.granules();
  const std::uint64_t granules = granules_of(size);
  ATRIUM_RETURN_IF_ERROR(fits(record.id, granules, old_granules));
  auto slot = arena_->resize(record.slot, old_granules, granules);
  while (!slot) {
    ATRIUM_RETURN_IF_ERROR(evict_one(record.id, granules, old_granules));
    slot = arena_->resize(record.slot, old_granules, granules);
  }
  record.slot = *slot;
  record.length = size;
  if (size > old_length) std::ranges::fill(payload_of(record).subspan(old_length), std::byte{0});
  live_bytes_[kind_index(record.id)] += size - old_length;  // modulo 2^64
  pinned_bytes_ -= old_granules * kGranule;
  count_pinned(granules);
  policy_->on_resize(record.number, granules * kGranule);
  return {};
}

Status ClusterStore::write_back(StoredRecord& record) {
  const std::uint32_t version = record.on_disk.exists() ? record.on_disk.version + 1 : 0;
  const auto written = write_image(image_of(record), record.id, record.length, version);
  if (!written.ok()) return written.status();
  if (record.on_disk.exists()) leave_extent(record.on_disk);
  record.on_disk = *written;
  record.dirty = false;
  ++counters_.writes;
  counters_.bytes_written += record.length;
  return {};
}

Result<StoredExtent> ClusterStore::write_image(std::span<std::byte> image, RecordId id,
                                               std::uint64_t length, std::uint32_t version) {
  if (!failed_.ok()) return failed_;
  const IoClock clock(counters_.io_seconds);
  const auto first = pages_->allocate(image.size() / kGranule);
  if (!first.ok()) return first.status();
  StoredExtent extent{.first = *first, .length = length, .epoch = epoch_ + 1, .version = version};
  extent.header_hash = seal_record(image, id, extent, uuid_);
  const Status status = pages_->write(*first, image);
  if (!status.ok()) {
    pages_->free(*first, extent.granules());
    return status;
  }
  counters_.overhead_bytes += image.size() - length;
  return extent;
}

Status ClusterStore::read_image(std::span<std::byte> image, RecordId id, const StoredExtent& extent,
                                const StoreUuid& uuid) {
  {
    const IoClock clock(counters_.io_seconds);
    ATRIUM_RETURN_IF_ERROR(pages_->read(extent.first, image));
  }
  const std::string fault = record_fault(image, id, extent, uuid);
  if (fault.empty()) return {};
  return unless_moved_on(
      Status(Code::kStore, pages_->path_of(extent.first),
             to_string(id) + " at " + PageFile::place_of(extent.first), fault, kDamageRemedy),
      kStepsToReuse);
}

// A record has another extent now. No root names what was written since the last one.
void ClusterStore::leave_extent(const StoredExtent& extent) {
  if (extent.epoch > epoch_)
    pages_->free(extent.first, extent.granules());
  else
    pages_->retire(extent.first, extent.granules());
}

void ClusterStore::will_read(std::span<const RecordId> ids) {
  const IoClock clock(counters_.io_seconds);
  for (const RecordId id : ids) {
    const StoredRecord& record = records_.at(id);
    if (!record.resident()) pages_->will_read(record.on_disk.first, record.granules());
  }
}

std::size_t ClusterStore::size(RecordId id) const {
  const auto found = records_.find(id);
  ATRIUM_CHECK(found != records_.end());
  return found->second.length;
}

std::vector<RecordId> ClusterStore::record_ids() const {
  std::vector<RecordId> ids;
  ids.reserve(records_.size());
  for (const auto& [id, record] : records_) ids.push_back(id);
  std::ranges::sort(ids);
  return ids;
}

std::uint64_t ClusterStore::live_bytes(RecordKind kind) const {
  return live_bytes_[static_cast<std::size_t>(kind)];
}

std::uint64_t ClusterStore::live_bytes() const {
  std::uint64_t bytes = 0;
  for (const std::uint64_t of_kind : live_bytes_) bytes += of_kind;
  return bytes;
}

std::uint64_t ClusterStore::file_bytes() const { return pages_->file_bytes() + kRootFileBytes; }

std::size_t ClusterStore::arena_cost(std::size_t payload_bytes) {
  return granules_of(payload_bytes) * kGranule;
}
std::size_t ClusterStore::arena_bytes() const { return arena_->granules() * kGranule; }
std::size_t ClusterStore::arena_used_bytes() const { return arena_->used_granules() * kGranule; }
std::size_t ClusterStore::arena_peak_bytes() const { return arena_->peak_granules() * kGranule; }

std::size_t ClusterStore::directory_bytes() const {
  // A node of the table and its bucket; a place in the list and in the table of an LRU; at a
  // checkpoint the sorted rows and the image they are written from.
  constexpr std::size_t kPointers = 10 * sizeof(void*);
  constexpr std::size_t kPerRecord = sizeof(std::pair<const RecordId, StoredRecord>) + kPointers +
                                     2 * sizeof(DirectoryEntry) + sizeof(StoredRecord*);
  return records_.size() * kPerRecord;
}

}  // namespace atrium
