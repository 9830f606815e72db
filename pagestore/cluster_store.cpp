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
#include "pagestore/trace_writer.h"
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

// Holes between records of many sizes take up to a tenth of an arena. [facts: best fit on granules
// stays 0.89 to 0.91 full]
constexpr std::size_t kShareForHoles = 8;
// What is read ahead of its request at a time: enough to keep a disk busy [facts: 4 MB, depth 16],
// and no more than this share of the arena.
constexpr std::size_t kReadAhead = std::size_t{4} << 20;
constexpr std::size_t kShareReadAhead = 4;

std::size_t kind_index(RecordId id) {
  const auto kind = static_cast<std::size_t>(kind_of(id));
  ATRIUM_CHECK(kind < kRecordKinds);
  return kind;
}

}  // namespace

StoreCounters StoreCounters::operator-(const StoreCounters& before) const {
  return {.requests = requests - before.requests,
          .reads = reads - before.reads,
          .reads_ahead = reads_ahead - before.reads_ahead,
          .writes = writes - before.writes,
          .bytes_read = bytes_read - before.bytes_read,
          .bytes_written = bytes_written - before.bytes_written,
          .checkpoint_writes = checkpoint_writes - before.checkpoint_writes,
          .checkpoint_bytes = checkpoint_bytes - before.checkpoint_bytes,
          .evictions = evictions - before.evictions,
          .fragmentation_evictions = fragmentation_evictions - before.fragmentation_evictions,
          .compactions = compactions - before.compactions,
          .streamed_reads = streamed_reads - before.streamed_reads,
          .streamed_bytes_read = streamed_bytes_read - before.streamed_bytes_read,
          .streamed_writes = streamed_writes - before.streamed_writes,
          .streamed_bytes_written = streamed_bytes_written - before.streamed_bytes_written,
          .checkpoints = checkpoints - before.checkpoints,
          .overhead_bytes = overhead_bytes - before.overhead_bytes,
          .io_seconds = io_seconds - before.io_seconds,
          .stall_seconds = stall_seconds - before.stall_seconds};
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
  if (store.trace_ != nullptr) store.trace_->dirty(id_, record.length);
}

Result<ClusterEdit> ClusterEdit::of(ClusterPin pin) {
  ATRIUM_CHECK(pin.store_ != nullptr && pin.store_->writes());
  ATRIUM_RETURN_IF_ERROR(pin.store_->claim(*pin.record_, pin.record_->granules()));
  ClusterEdit edit(*pin.store_, *pin.record_);
  pin.store_ = nullptr;  // its pin is the edit's now
  return edit;
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

std::size_t ClusterStore::charge_of(std::uint64_t length) const {
  return charges_payload_ ? length : arena_cost(length);
}

void ClusterStore::charge(std::size_t bytes) {
  resident_bytes_ += bytes;
  resident_peak_bytes_ = std::max(resident_peak_bytes_, resident_bytes_);
}

void ClusterStore::count_pinned(std::size_t bytes) {
  pinned_bytes_ += bytes;
  pinned_peak_bytes_ = std::max(pinned_peak_bytes_, pinned_bytes_);
}

StoredRecord& ClusterStore::record_of(RecordId id) {
  const auto found = records_.find(id);
  ATRIUM_CHECK(found != records_.end() && found->second.exists());
  return found->second;
}

// A request begins: is its record in the arena?
bool ClusterStore::hits(const StoredRecord& record) {
  come_into_sight();
  if (record.resident())
    policy_->on_hit(record.number);
  else
    policy_->on_miss(record.number, charge_of(record.length));
  return record.resident();
}

Result<ClusterPin> ClusterStore::read(RecordId id) {
  StoredRecord& record = record_of(id);
  if (!hits(record)) ATRIUM_RETURN_IF_ERROR(bring_in(record));
  count_request(record);
  return ClusterPin(*this, record);
}

Result<ClusterEdit> ClusterStore::edit(RecordId id) {
  ATRIUM_CHECK(writes());
  Result<ClusterPin> record = read(id);
  if (!record.ok()) return record.status();
  return ClusterEdit::of(std::move(record).value());
}

StoredRecord& ClusterStore::add_record(StoredRecord record) {
  record.number = static_cast<RecordNumber>(by_number_.size());
  StoredRecord& added = records_.emplace(record.id, record).first->second;
  by_number_.push_back(&added);
  live_bytes_[kind_index(record.id)] += record.length;
  return added;
}

// A record as it is now, in the place of what it was; a dropped one has no length.
StoredRecord& ClusterStore::put_record(const StoredRecord& record) {
  const auto found = records_.find(record.id);
  if (found == records_.end()) return add_record(record);
  live_bytes_[kind_index(record.id)] += record.length - found->second.length;  // modulo 2^64
  return found->second = record;
}

void ClusterStore::count_request(StoredRecord& record) {
  ++counters_.requests;
  if (record.pins++ == 0) count_pinned(charge_of(record.length));
  if (trace_ != nullptr) trace_->read(record.id, record.length);
  look_ahead(record);
}

Result<std::optional<ClusterPin>> ClusterStore::read_or_pass(RecordId id) {
  StoredRecord& record = record_of(id);
  if (!hits(record)) {
    const std::size_t bytes = charge_of(record.length);
    if (bytes > capacity_ || !policy_->admits(record.number, bytes)) {
      ATRIUM_RETURN_IF_ERROR(pass(record));
      return std::optional<ClusterPin>();
    }
    ATRIUM_RETURN_IF_ERROR(bring_in(record));
  }
  count_request(record);
  return std::optional(ClusterPin(*this, record));
}

// Of the request that is being made: foreseen or not.
Status ClusterStore::read_requested(std::span<std::byte> image, const StoredRecord& record) {
  const bool foreseen = foresight_.next_of(record.number) == foresight_.now();
  return read_image(image, record.id, record.on_disk, uuid_,
                    foreseen ? Known::kBefore : Known::kNow);
}

// A request that leaves the arena as it is.
Status ClusterStore::pass(StoredRecord& record) {
  if (record.coming) {
    ATRIUM_RETURN_IF_ERROR(end_read_ahead(record));
    leave_slot(record);
  } else {
    const auto image = streamed_.granules(record.granules());
    ATRIUM_RETURN_IF_ERROR(read_requested(image, record));
  }
  ++counters_.reads;
  counters_.bytes_read += record.length;
  ++counters_.requests;
  look_ahead(record);
  return {};
}

void ClusterStore::release(StoredRecord& record) {
  ATRIUM_CHECK(record.pins > 0);
  if (trace_ != nullptr) trace_->release(record.id);
  if (--record.pins > 0) return;
  pinned_bytes_ -= charge_of(record.length);
  policy_->on_release(record.number);
}

Status ClusterStore::bring_in(StoredRecord& record) {
  const std::size_t bytes = charge_of(record.length);
  ATRIUM_RETURN_IF_ERROR(make_room(record.id, bytes));
  if (record.coming) {
    ATRIUM_RETURN_IF_ERROR(end_read_ahead(record));
    ++counters_.reads_ahead;
  } else {
    const auto slot = find_slot(record.id, record.granules());
    if (!slot.ok()) return slot.status();
    const auto image = arena_->image(*slot, record.granules());
    const Status status = read_requested(image, record);
    if (!status.ok()) {
      arena_->free(*slot, record.granules());
      return status;
    }
    record.slot = *slot;
  }
  charge(bytes);
  policy_->on_insert(record.number, bytes);
  ++counters_.reads;
  counters_.bytes_read += record.length;
  return {};
}

Status ClusterStore::create_record(RecordId id, std::span<const std::byte> payload) {
  ATRIUM_CHECK(writes() && !contains(id));
  ATRIUM_CHECK(kind_of(id) != RecordKind::kDirectory);
  const auto dropped = records_.find(id);
  StoredRecord made;
  if (dropped != records_.end()) made = dropped->second;
  made.id = id;
  made.length = payload.size();
  made.dirty = true;
  const std::size_t bytes = charge_of(made.length);
  ATRIUM_RETURN_IF_ERROR(make_room(id, bytes));
  const auto slot = find_slot(id, made.granules());
  if (!slot.ok()) return slot.status();
  const Status claimed = claim(made, made.granules());
  if (!claimed.ok()) {
    arena_->free(*slot, made.granules());
    return claimed;
  }
  made.slot = *slot;
  std::ranges::copy(payload, payload_of(made).begin());
  const StoredRecord& record = put_record(made);
  charge(bytes);
  policy_->on_insert(record.number, bytes);
  tell_next(record);
  policy_->on_release(record.number);
  if (trace_ != nullptr) trace_->create_record(id, payload.size());
  return {};
}

// Can the arena hold this beside what is pinned? own_bytes: what the record has of the pinned ones
// already.
Status ClusterStore::fits(RecordId id, std::size_t bytes, std::size_t own_bytes) const {
  const std::size_t others = pinned_bytes_ - own_bytes;
  if (bytes + others <= capacity_) return {};
  return Status(Code::kUsage, dir_, to_string(id),
                "arena too small: it takes " + std::to_string(bytes) + " bytes beside " +
                    std::to_string(others) + " pinned, of " + std::to_string(capacity_),
                "give an arena of at least " + std::to_string(bytes + others) + " bytes");
}

// Room, as charged, for this much more: in the policy's order.
Status ClusterStore::make_room(RecordId id, std::size_t bytes) {
  ATRIUM_RETURN_IF_ERROR(fits(id, bytes, 0));
  while (resident_bytes_ + bytes > capacity_) ATRIUM_RETURN_IF_ERROR(evict_one());
  return {};
}

// A hole of this size: there is room enough, but it may be in pieces.
Result<std::uint64_t> ClusterStore::find_slot(RecordId id, std::uint64_t granules) {
  for (;;) {
    if (const auto slot = arena_->allocate(granules)) return *slot;
    if (!compact(nullptr) && !give_up_reads())
      ATRIUM_RETURN_IF_ERROR(evict_for_a_hole(id, granules));
  }
}

Status ClusterStore::evict_one() {
  const auto victim = policy_->victim(foresight_.now());
  ATRIUM_CHECK(victim.has_value());  // what is pinned leaves room: fits()
  StoredRecord& record = *by_number_[*victim];
  ATRIUM_CHECK(record.resident() && record.pins == 0);
  if (record.dirty) ATRIUM_RETURN_IF_ERROR(write_back(record));
  leave_slot(record);
  resident_bytes_ -= charge_of(record.length);
  policy_->on_evict(record.number);
  ++counters_.evictions;
  // It is wanted again before what was looked at last: it has to be read ahead once more.
  scanned_ = std::min(scanned_, foresight_.next_of(record.number));
  return {};
}

void ClusterStore::leave_slot(StoredRecord& record) {
  arena_->free(record.slot, record.granules());
  record.slot = kNoGranule;
}

Status ClusterStore::evict_for_a_hole(RecordId id, std::uint64_t granules) {
  if (resident_bytes_ == pinned_bytes_)
    return Status(Code::kUsage, dir_, to_string(id),
                  "arena too small: " + std::to_string(arena_->free_granules() * kGranule) +
                      " bytes are free, but pinned records part them, and it takes " +
                      std::to_string(granules * kGranule) + " in one piece",
                  "give an arena of at least " +
                      std::to_string(capacity_ + granules * kGranule) + " bytes");
  ++counters_.fragmentation_evictions;
  return evict_one();
}

// Slides the records together that may be moved, towards the arena's start. False where that
// changes nothing. movable: one that is pinned, and may be moved all the same.
bool ClusterStore::compact(const StoredRecord* movable) {
  std::vector<StoredRecord*> in_arena;
  for (StoredRecord* record : by_number_)
    if (record->slot != kNoGranule) in_arena.push_back(record);
  std::ranges::sort(in_arena, {}, &StoredRecord::slot);
  std::uint64_t end = 0;  // of what stands fast so far
  bool moved = false;
  for (StoredRecord* record : in_arena) {
    const bool fixed = record->coming || (record->pins > 0 && record != movable);
    if (!fixed && record->slot > end) {
      arena_->move(record->slot, record->granules(), end);
      record->slot = end;
      moved = true;
    }
    end = record->slot + record->granules();
  }
  counters_.compactions += moved ? 1 : 0;
  return moved;
}

Status ClusterStore::resize(StoredRecord& record, std::size_t size) {
  const std::uint64_t old_length = record.length;
  const std::uint64_t old_granules = record.granules(), granules = granules_of(size);
  const std::size_t old_bytes = charge_of(old_length), bytes = charge_of(size);
  ATRIUM_RETURN_IF_ERROR(fits(record.id, bytes, old_bytes));
  ATRIUM_RETURN_IF_ERROR(claim(record, granules));
  while (resident_bytes_ - old_bytes + bytes > capacity_) ATRIUM_RETURN_IF_ERROR(evict_one());
  auto slot = arena_->resize(record.slot, old_granules, granules);
  while (!slot) {
    if (!compact(&record) && !give_up_reads())
      ATRIUM_RETURN_IF_ERROR(evict_for_a_hole(record.id, granules));
    slot = arena_->resize(record.slot, old_granules, granules);
  }
  record.slot = *slot;
  record.length = size;
  if (size > old_length) std::ranges::fill(payload_of(record).subspan(old_length), std::byte{0});
  live_bytes_[kind_index(record.id)] += size - old_length;  // modulo 2^64
  resident_bytes_ -= old_bytes;
  charge(bytes);
  pinned_bytes_ -= old_bytes;
  count_pinned(bytes);
  policy_->on_resize(record.number, bytes);
  if (trace_ != nullptr) trace_->dirty(record.id, size);
  return {};
}

std::size_t ClusterStore::size(RecordId id) const {
  const auto found = records_.find(id);
  ATRIUM_CHECK(found != records_.end());
  return found->second.length;
}

std::vector<RecordId> ClusterStore::record_ids() const {
  std::vector<RecordId> ids;
  ids.reserve(records_.size());
  for (const auto& [id, record] : records_)
    if (record.exists()) ids.push_back(id);
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

std::uint64_t ClusterStore::allocated_bytes() const {
  return pages_->file_bytes() - pages_->free_granules() * kGranule;
}

std::size_t ClusterStore::arena_cost(std::size_t payload_bytes) {
  return granules_of(payload_bytes) * kGranule;
}

std::size_t ClusterStore::read_ahead_bytes(std::size_t capacity) {
  return std::min(capacity / kShareReadAhead, kReadAhead) / kGranule * kGranule;
}

std::size_t ClusterStore::arena_memory(std::size_t capacity) {
  const std::size_t granules = capacity / kGranule;
  const std::size_t holes = granules / kShareForHoles + 1;
  return (granules + holes) * kGranule + read_ahead_bytes(capacity);
}

std::size_t ClusterStore::directory_bytes() const {
  // A node of the table and its bucket; a place in the list and in the table of an LRU; at a
  // checkpoint the sorted rows and the image they are written from.
  constexpr std::size_t kPointers = 10 * sizeof(void*);
  constexpr std::size_t kPerRecord = sizeof(std::pair<const RecordId, StoredRecord>) + kPointers +
                                     2 * sizeof(DirectoryEntry) + sizeof(StoredRecord*);
  return records_.size() * kPerRecord + foresight_.bytes() + streamed_.size();
}

}  // namespace atrium
