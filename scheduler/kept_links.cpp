#include "scheduler/kept_links.h"

#include <utility>

#include "engine/check.h"
#include "scheduler/braid_record.h"

namespace atrium {

namespace {

RecordId braids_of(ClusterId receiver) { return record_id(RecordKind::kBraids, receiver.value); }

}  // namespace

KeptLinks::KeptLinks(ClusterStore& store, std::size_t clusters)
    : store_(store), kept_(clusters) {
  for (std::size_t c = 0; c < clusters; ++c) {
    const RecordId record = braids_of(ClusterId(c));
    kept_[c].on_disk = store.contains(record);
    if (kept_[c].on_disk) kept_[c].bytes = store.size(record);  // about, until it is read
  }
}

Result<std::vector<Braid>*> KeptLinks::of(ClusterId receiver) {
  ATRIUM_CHECK(has(receiver));
  return bring(receiver);
}

Result<std::span<const Braid>> KeptLinks::past(ClusterId receiver) {
  if (!kept_[receiver.value].past) return std::span<const Braid>();
  const Result<std::vector<Braid>*> braids = bring(receiver);
  if (!braids.ok()) return braids.status();
  return std::span<const Braid>(**braids);
}

void KeptLinks::become_past(ClusterId receiver) {
  Kept& kept = kept_[receiver.value];
  kept.past = kept.braids || kept.on_disk;
}

Result<std::vector<Braid>*> KeptLinks::bring(ClusterId receiver) {
  Kept& kept = kept_[receiver.value];
  if (kept.braids) return &*kept.braids;
  const Result<std::span<const std::byte>> record = store_.stream_in(braids_of(receiver));
  if (!record.ok()) return record.status();
  Result<std::vector<Braid>> braids = read_braids(*record);
  if (!braids.ok()) return braids.status();
  const std::uint64_t bytes = kept.bytes = bytes_of(*braids);
  if (bytes_ + bytes > budget_) {
    streamed_ = std::move(*braids);
    return &streamed_;
  }
  kept.braids = std::move(*braids);
  bytes_ += bytes;
  return &*kept.braids;
}

Status KeptLinks::keep(ClusterId receiver, std::vector<Braid> braids) {
  Kept& kept = kept_[receiver.value];
  const std::uint64_t bytes = bytes_of(braids), replaced = kept.braids ? kept.bytes : 0;
  std::vector<bool> carrying;
  for (const Braid& b : braids) carrying.push_back(b.carries_light());
  if (bytes_ - replaced + bytes > budget_) {
    ATRIUM_RETURN_IF_ERROR(write(receiver, braids));
    bytes_ -= replaced;
    kept = {.bytes = bytes, .on_disk = true, .carrying = std::move(carrying)};
    return {};
  }
  forget(receiver);
  kept = {.braids = std::move(braids), .bytes = bytes, .carrying = std::move(carrying)};
  bytes_ += bytes;
  return {};
}

Status KeptLinks::write(ClusterId receiver, std::span<const Braid> braids) {
  ATRIUM_RETURN_IF_ERROR(store_.stream_out(braids_of(receiver), write_braids(braids)));
  kept_[receiver.value].on_disk = true;
  return {};
}

Status KeptLinks::fit(std::uint64_t budget, std::span<const ClusterId> order) {
  budget_ = budget;
  for (std::size_t i = order.size(); i-- > 0 && bytes_ > budget_;) {
    Kept& kept = kept_[order[i].value];
    if (!kept.braids) continue;
    if (!kept.on_disk) ATRIUM_RETURN_IF_ERROR(write(order[i], *kept.braids));
    kept.braids.reset();
    bytes_ -= kept.bytes;
  }
  return {};
}

LinksKept KeptLinks::kept() const {
  LinksKept sum;
  for (const Kept& k : kept_) {
    const bool streamed = !k.braids && k.on_disk;
    sum.in_memory += k.braids.has_value();
    sum.in_memory_bytes += k.braids ? k.bytes : 0;
    sum.streamed += streamed;
    sum.streamed_bytes += streamed ? k.bytes : 0;
  }
  return sum;
}

Status KeptLinks::save() {
  for (std::size_t c = 0; c < kept_.size(); ++c)
    if (kept_[c].braids && !kept_[c].on_disk)
      ATRIUM_RETURN_IF_ERROR(write(ClusterId(c), *kept_[c].braids));
  return {};
}

void KeptLinks::forget(ClusterId receiver) {
  Kept& kept = kept_[receiver.value];
  if (store_.contains(braids_of(receiver))) store_.drop_streamed(braids_of(receiver));
  if (kept.braids) bytes_ -= kept.bytes;
  kept = {};
}

void KeptLinks::forget_all() {
  for (std::size_t c = 0; c < kept_.size(); ++c) forget(ClusterId(c));
  streamed_.clear();
}

}  // namespace atrium
