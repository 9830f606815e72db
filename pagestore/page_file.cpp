#include "pagestore/page_file.h"

#include <algorithm>
#include <cstdio>

#include "engine/check.h"
#include "pagestore/record.h"

namespace atrium {

namespace {

constexpr std::uint64_t kFirstSegmentGranules = (std::uint64_t{1} << 20) / kGranule;
constexpr std::uint64_t kLargestSegmentGranules = (std::uint64_t{256} << 20) / kGranule;

// An address is the segment in the upper half and the granule in it in the lower, so that runs of
// two segments never touch.
constexpr int kSegmentShift = 32;
constexpr std::uint64_t address(std::size_t segment, std::uint64_t granule) {
  return (std::uint64_t{segment} << kSegmentShift) | granule;
}
constexpr std::size_t segment_of(std::uint64_t first) { return first >> kSegmentShift; }
constexpr std::uint64_t byte_of(std::uint64_t first) {
  return (first & ((std::uint64_t{1} << kSegmentShift) - 1)) * kGranule;
}

std::uint64_t regular_granules(std::size_t segment) {
  std::uint64_t granules = kFirstSegmentGranules;
  for (std::size_t i = 0; i < segment && granules < kLargestSegmentGranules; ++i) granules *= 2;
  return granules;
}

}  // namespace

std::uint64_t PageFile::file_bytes_for(std::uint64_t bytes) {
  std::uint64_t granules = 0;
  for (std::size_t i = 0; granules * kGranule < bytes; ++i) granules += regular_granules(i);
  return granules * kGranule;
}

std::string PageFile::segment_path(std::size_t segment) const {
  char name[32];
  std::snprintf(name, sizeof name, "/pages.%04zu", segment);
  return dir_ + name;
}

std::string PageFile::path_of(std::uint64_t first) const { return segment_path(segment_of(first)); }

std::string PageFile::place_of(std::uint64_t first) {
  return "byte " + std::to_string(byte_of(first));
}

Result<std::unique_ptr<PageFile>> PageFile::open(Disk& disk, const std::string& dir,
                                                 DiskAccess access) {
  std::unique_ptr<PageFile> pages(new PageFile(disk, dir));
  ATRIUM_RETURN_IF_ERROR(pages->adopt_segments(access));
  return pages;
}

Status PageFile::adopt_segments(DiskAccess access) {
  while (disk_.exists(segment_path(segments_.size()))) {
    auto file = disk_.open(segment_path(segments_.size()), access);
    if (!file.ok()) return file.status();
    const auto size = (*file)->size();
    if (!size.ok()) return size.status();
    const std::uint64_t granules = *size / kGranule;
    // Its making may have been cut short after it got its length.
    if (access == DiskAccess::kReadWrite && granules > 0)
      ATRIUM_RETURN_IF_ERROR((*file)->allocate(granules * kGranule));
    segments_.push_back({std::move(*file), granules, false});
  }
  // One that was made and not yet reserved is made again when it is needed.
  if (!segments_.empty() && segments_.back().granules == 0) segments_.pop_back();
  forget_what_is_taken();
  return {};
}

void PageFile::forget_what_is_taken() {
  holes_ = {};
  retired_now_.clear();
  retired_before_.clear();
  for (std::size_t i = 0; i < segments_.size(); ++i)
    if (segments_[i].granules > 0) holes_.free(address(i, 0), segments_[i].granules);
}

Result<std::uint64_t> PageFile::allocate(std::uint64_t granules) {
  if (const auto first = holes_.allocate(granules)) return *first;
  ATRIUM_RETURN_IF_ERROR(grow(granules));
  const auto first = holes_.allocate(granules);
  ATRIUM_CHECK(first.has_value());
  return *first;
}

// Where the disk is too full for a segment of the regular size a smaller one may do.
Status PageFile::grow(std::uint64_t granules) {
  std::uint64_t wanted = std::max(granules, regular_granules(segments_.size()));
  Status status = add_segment(wanted);
  while (!status.ok() && wanted > granules) {
    wanted = std::max(granules, wanted / 2);
    status = add_segment(wanted);
  }
  return status;
}

Status PageFile::add_segment(std::uint64_t granules) {
  const std::size_t segment = segments_.size();
  auto file = disk_.open(segment_path(segment), DiskAccess::kReadWrite);
  if (!file.ok()) return file.status();
  const Status reserved = (*file)->allocate(granules * kGranule);
  if (!reserved.ok()) {
    // What it has got already would only keep the disk full; that it goes is no condition.
    static_cast<void>(disk_.remove(segment_path(segment)));
    return reserved;
  }
  segments_.push_back({std::move(*file), granules, true});
  directory_unsynced_ = true;
  holes_.free(address(segment, 0), granules);
  return {};
}

void PageFile::root_is_durable() {
  for (const auto& [first, granules] : retired_before_) holes_.free(first, granules);
  retired_before_ = std::move(retired_now_);
  retired_now_.clear();
}

Status PageFile::write(std::uint64_t first, std::span<const std::byte> image) {
  Segment& segment = segments_[segment_of(first)];
  segment.unsynced = true;
  return write_all(*segment.file, byte_of(first), image);
}

Result<DiskFile*> PageFile::file_of(std::uint64_t first) {
  if (segment_of(first) < segments_.size()) return segments_[segment_of(first)].file.get();
  return Status(Code::kStore, path_of(first), place_of(first), "there is no such page file",
                kDamageRemedy);
}

Status PageFile::read(std::uint64_t first, std::span<std::byte> image, Known known) {
  const auto file = file_of(first);
  if (!file.ok()) return file.status();
  if (known == Known::kNow) return (*file)->read(byte_of(first), image);
  (*file)->will_read(byte_of(first), image.size());
  return (*file)->read_announced(byte_of(first), image);
}

Status PageFile::queue_read(ReadQueue& queue, std::uint64_t first, std::span<std::byte> image,
                            std::uint64_t ticket) {
  const auto file = file_of(first);
  if (!file.ok()) return file.status();
  queue.submit(**file, byte_of(first), image, ticket);
  return {};
}

Status PageFile::sync() {
  for (Segment& segment : segments_) {
    if (!segment.unsynced) continue;
    ATRIUM_RETURN_IF_ERROR(segment.file->sync());
    segment.unsynced = false;
  }
  if (!directory_unsynced_) return {};
  ATRIUM_RETURN_IF_ERROR(disk_.sync_directory(dir_));
  directory_unsynced_ = false;
  return {};
}

std::uint64_t PageFile::file_bytes() const {
  std::uint64_t granules = 0;
  for (const Segment& segment : segments_) granules += segment.granules;
  return granules * kGranule;
}

}  // namespace atrium
