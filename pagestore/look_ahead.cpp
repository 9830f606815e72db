// Looking ahead: what the store does with the requests it was told of. It tells the policy when a
// record is wanted next, and it reads records before they are asked for, into the arena's memory
// but not into the arena: they are charged, and others leave for them, when their request comes.
#include <algorithm>

#include "pagestore/arena.h"
#include "pagestore/cluster_store.h"
#include "pagestore/io_clock.h"
#include "pagestore/page_file.h"

namespace atrium {

void ClusterStore::foresee(std::span<const RecordId> ids) {
  for (const RecordId id : ids) {
    const StoredRecord& record = records_.at(id);
    const bool first = foresight_.next_of(record.number) == kNeverAgain;
    foresight_.append(record.number);
    if (first) tell_next(record);
  }
  read_ahead();
}

void ClusterStore::forget_foreseen() {
  foresight_.forget();
  scanned_ = foresight_.now();
}

void ClusterStore::look_ahead(const StoredRecord& requested) {
  foresight_.advance(requested.number);
  tell_next(requested);
  read_ahead();
}

// A request begins, and with it one more comes into sight: its record's next, unless an earlier
// one is.
void ClusterStore::come_into_sight() {
  if (choice_.foresight == 0 || choice_.foresight >= foreseen()) return;
  const std::uint64_t farthest = foresight_.now() + choice_.foresight;
  const StoredRecord& seen = *by_number_[foresight_.at(farthest)];
  if (seen.resident() && foresight_.next_of(seen.number) == farthest)
    policy_->on_foreseen(seen.number, farthest);
}

// Between two requests: may the policy know of this one yet?
bool ClusterStore::in_sight(std::uint64_t number) const {
  return number != kNeverAgain && number - foresight_.now() < choice_.foresight;
}

void ClusterStore::tell_next(const StoredRecord& record) {
  const std::uint64_t next = foresight_.next_of(record.number);
  if (record.resident() && in_sight(next)) policy_->on_foreseen(record.number, next);
}

void ClusterStore::read_ahead() {
  scanned_ = std::max(scanned_, foresight_.now());
  for (; scanned_ < foresight_.end(); ++scanned_)
    if (!read_one_ahead(*by_number_[foresight_.at(scanned_)])) return;
}

// False where there is no room for it, or enough under way: to be tried again later.
bool ClusterStore::read_one_ahead(StoredRecord& record) {
  const std::size_t bytes = arena_cost(record.length), most = read_ahead_bytes(capacity_);
  if (record.slot != kNoGranule || !record.exists() || bytes > most) return true;
  if (coming_bytes_ + bytes > most) return false;
  const auto slot = arena_->allocate(record.granules());
  if (!slot) return false;
  const IoClock clock(counters_.io_seconds);
  const auto image = arena_->image(*slot, record.granules());
  if (!pages_->queue_read(*queue_, record.on_disk.first, image, record.number).ok()) {
    arena_->free(*slot, record.granules());  // its request will say why
    return true;
  }
  record.slot = *slot;
  record.coming = true;
  coming_bytes_ += bytes;
  return true;
}

// What was read ahead makes way for what is asked for now, to be read again. False if there was
// nothing.
bool ClusterStore::give_up_reads() {
  if (coming_bytes_ == 0) return false;
  for (StoredRecord* record : by_number_) {
    if (!record->coming || !end_read_ahead(*record).ok()) continue;  // its request will say why
    leave_slot(*record);
  }
  scanned_ = foresight_.now();
  return true;
}

// Waits for the record's bytes, and checks them. On error the record is where it was: on disk.
Status ClusterStore::end_read_ahead(StoredRecord& record) {
  Status status;
  {
    const IoClock clock(counters_.io_seconds), stall(counters_.stall_seconds);
    status = queue_->wait(record.number);
  }
  record.coming = false;
  coming_bytes_ -= arena_cost(record.length);
  if (status.ok()) status = check_image(image_of(record), record.id, record.on_disk, uuid_);
  if (status.ok()) return {};
  leave_slot(record);
  return status;
}

}  // namespace atrium
