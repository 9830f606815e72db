// Records and their extents: where a record will be written next is claimed when it becomes dirty,
// so that neither an eviction nor a checkpoint has to ask the disk for room.
//
// A dirty record's extents, from one root (epoch e) to the next:
//
//                    on_disk            claim                written                    root e+1
//   first change     of epoch <= e      new                  on_disk retired; the claim is on_disk
//   changed again    of epoch e + 1     the same extent      over itself: no root names it
#include <algorithm>

#include "engine/check.h"
#include "pagestore/cluster_store.h"
#include "pagestore/io_clock.h"
#include "pagestore/page_file.h"

namespace atrium {

namespace {

// What root e names is only reused when root e + 2 is durable.
constexpr std::uint64_t kStepsToReuse = 2;
// Claimed for the state of the next checkpoint; a larger one asks for its room then.
constexpr std::uint64_t kStateGranules = 4;
// The directory's claim grows by this share at a time.
constexpr std::uint64_t kDirectoryMargin = 4;

}  // namespace

// Makes sure that a record of this many granules can be written. On error nothing has changed.
Status ClusterStore::claim(StoredRecord& record, std::uint64_t granules) {
  ATRIUM_RETURN_IF_ERROR(claim_own_records());
  const bool only_here = record.on_disk.exists() && record.on_disk.epoch > epoch_;
  if (!record.claim.exists() && only_here) {
    record.claim = {record.on_disk.first, record.on_disk.granules()};
    record.on_disk = {};
  }
  return claim_run(record.claim, granules);
}

Status ClusterStore::claim_own_records() {
  const std::uint64_t directory = granules_of((records_.size() + 1) * sizeof(DirectoryEntry));
  if (directory_claim_.granules < directory)
    ATRIUM_RETURN_IF_ERROR(claim_run(directory_claim_, directory + directory / kDirectoryMargin));
  return claim_run(state_claim_, kStateGranules);
}

// Makes `run` at least this large; what it has already is given back after the new one is there.
Status ClusterStore::claim_run(Run& run, std::uint64_t granules) {
  if (run.granules >= granules) return {};
  if (!failed_.ok()) return failed_;
  const IoClock clock(counters_.io_seconds);
  const auto first = pages_->allocate(granules);
  if (!first.ok()) return first.status();
  if (run.exists()) pages_->free(run.first, run.granules);
  run = {*first, granules};
  return {};
}

Status ClusterStore::write_back(StoredRecord& record) {
  const auto written =
      write_image(image_of(record), record.id, record.length, record.version, record.claim);
  if (!written.ok()) return written.status();
  if (record.on_disk.exists()) leave_extent(record.on_disk);
  record.on_disk = *written;
  record.dirty = false;
  ++record.version;
  ++counters_.writes;
  counters_.bytes_written += record.length;
  return {};
}

// Writes an image to what was claimed for it; what is too much of that is given back. On error the
// claim stays.
Result<StoredExtent> ClusterStore::write_image(std::span<std::byte> image, RecordId id,
                                               std::uint64_t length, std::uint32_t version,
                                               Run& claim) {
  if (!failed_.ok()) return failed_;
  const IoClock clock(counters_.io_seconds);
  const std::uint64_t granules = image.size() / kGranule;
  ATRIUM_CHECK(claim.granules >= granules);
  StoredExtent extent{
      .first = claim.first, .length = length, .epoch = epoch_ + 1, .version = version};
  extent.header_hash = seal_record(image, id, extent, uuid_);
  ATRIUM_RETURN_IF_ERROR(pages_->write(claim.first, image));
  if (claim.granules > granules)
    pages_->free(claim.first + granules, claim.granules - granules);
  claim = {};
  counters_.overhead_bytes += image.size() - length;
  return extent;
}

Status ClusterStore::read_image(std::span<std::byte> image, RecordId id, const StoredExtent& extent,
                                const StoreUuid& uuid, Known known) {
  {
    const IoClock clock(counters_.io_seconds), stall(counters_.stall_seconds);
    ATRIUM_RETURN_IF_ERROR(pages_->read(extent.first, image, known));
  }
  return check_image(image, id, extent, uuid);
}

Status ClusterStore::check_image(std::span<const std::byte> image, RecordId id,
                                 const StoredExtent& extent, const StoreUuid& uuid) {
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

Result<std::span<const std::byte>> ClusterStore::stream_in(RecordId id) {
  const StoredRecord& record = record_of(id);
  ATRIUM_CHECK(record.slot == kNoGranule);
  const auto image = streamed_.granules(record.granules());
  ATRIUM_RETURN_IF_ERROR(read_image(image, id, record.on_disk, uuid_, Known::kBefore));
  ++counters_.streamed_reads;
  counters_.streamed_bytes_read += record.length;
  return std::span<const std::byte>(image.subspan(sizeof(RecordHeader), record.length));
}

Status ClusterStore::stream_out(RecordId id, std::span<const std::byte> payload) {
  ATRIUM_CHECK(writes() && kind_of(id) != RecordKind::kDirectory);
  const auto image = streamed_.granules(granules_of(payload.size()));
  std::ranges::copy(payload, image.begin() + sizeof(RecordHeader));
  const auto found = records_.find(id);
  StoredRecord replaced;
  replaced.id = id;
  if (found != records_.end()) replaced = found->second;
  ATRIUM_CHECK(replaced.slot == kNoGranule);
  Run run;
  ATRIUM_RETURN_IF_ERROR(claim_own_records());
  ATRIUM_RETURN_IF_ERROR(claim_run(run, image.size() / kGranule));
  const auto written = write_image(image, id, payload.size(), replaced.version, run);
  if (!written.ok()) {
    pages_->free(run.first, run.granules);
    return written.status();
  }
  if (replaced.on_disk.exists()) leave_extent(replaced.on_disk);
  replaced.on_disk = *written;
  ++replaced.version;
  ++counters_.streamed_writes;
  counters_.streamed_bytes_written += payload.size();
  replaced.length = payload.size();
  put_record(replaced);
  return {};
}

void ClusterStore::drop_streamed(RecordId id) {
  StoredRecord dropped = record_of(id);
  ATRIUM_CHECK(dropped.slot == kNoGranule);
  leave_extent(dropped.on_disk);
  dropped.on_disk = {};
  dropped.length = 0;
  put_record(dropped);
}

}  // namespace atrium
