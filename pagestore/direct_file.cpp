#include "pagestore/direct_file.h"

#include <fcntl.h>

#include <algorithm>
#include <cstring>

#include "engine/check.h"
#include "pagestore/aligned_bytes.h"
#include "pagestore/record.h"

namespace atrium {

namespace {

constexpr std::size_t kBounceGranules = 64;
constexpr std::size_t kBounceBytes = kBounceGranules * kGranule;

std::uint64_t granule_floor(std::uint64_t bytes) { return bytes / kGranule * kGranule; }
std::uint64_t granule_ceil(std::uint64_t bytes) { return granule_floor(bytes + kGranule - 1); }

// EINVAL is how file systems refuse O_DIRECT, and disks with larger sectors our granules.
Status direct_failure(const std::string& path, const std::string& place, const std::string& doing,
                      int error) {
  if (error != EINVAL) return failure(path, place, doing, error);
  return Status(Code::kStore, path, place,
                doing + " failed: this file system refuses O_DIRECT here", "use --io mmap");
}

}  // namespace

bool DirectFile::aligned(std::uint64_t offset, std::span<const std::byte> bytes) {
  const auto address = reinterpret_cast<std::uintptr_t>(bytes.data());
  return (offset | bytes.size() | address) % kGranule == 0;
}

Status DirectFile::failed_read(std::uint64_t offset, int error) const {
  return direct_failure(path(), byte_place(offset), "a direct read", error);
}

Result<std::size_t> DirectFile::write_some(std::uint64_t offset, std::span<const std::byte> bytes) {
  ATRIUM_CHECK((offset | bytes.size()) % kGranule == 0);
  if (aligned(offset, bytes)) return write_granules(offset, bytes);
  const std::size_t part = std::min(bytes.size(), kBounceBytes);
  AlignedBytes scratch;
  const std::span<std::byte> bounce = scratch.granules(part / kGranule);
  std::memcpy(bounce.data(), bytes.data(), part);
  return write_granules(offset, bounce);
}

Result<std::size_t> DirectFile::write_granules(std::uint64_t offset,
                                               std::span<const std::byte> bytes) {
  const ssize_t written = retry_interrupted(
      [&] { return ::pwrite(fd(), bytes.data(), bytes.size(), static_cast<off_t>(offset)); });
  if (written < 0) return direct_failure(path(), byte_place(offset), "a direct write", errno);
  return granule_floor(static_cast<std::uint64_t>(written));
}

Status DirectFile::read(std::uint64_t offset, std::span<std::byte> bytes) {
  if (aligned(offset, bytes)) return read_granules(offset, bytes, bytes.size());
  AlignedBytes scratch;
  const std::span<std::byte> bounce = scratch.granules(kBounceGranules);
  while (!bytes.empty()) {
    const std::uint64_t begin = granule_floor(offset);
    const std::size_t before = offset - begin;
    const std::size_t part = std::min(bytes.size(), kBounceBytes - before);
    const std::span<std::byte> granules = bounce.first(granule_ceil(before + part));
    ATRIUM_RETURN_IF_ERROR(read_granules(begin, granules, before + part));
    std::memcpy(bytes.data(), granules.data() + before, part);
    offset += part;
    bytes = bytes.subspan(part);
  }
  return {};
}

// Reads until `enough` bytes are there: the file may end within the last granule.
Status DirectFile::read_granules(std::uint64_t offset, std::span<std::byte> bytes,
                                 std::size_t enough) {
  std::size_t done = 0;
  for (;;) {
    const ssize_t got = retry_interrupted([&] {
      return ::pread(fd(), bytes.data() + done, bytes.size() - done,
                     static_cast<off_t>(offset + done));
    });
    if (got < 0) return failed_read(offset + done, errno);
    const std::size_t now = done + static_cast<std::size_t>(got);
    if (now >= enough) return {};
    if (granule_floor(now) == done) return ends_early(path(), offset + now, offset + enough);
    done = granule_floor(now);
  }
}

Result<std::unique_ptr<DiskFile>> open_direct(const std::string& path, DiskAccess access) {
  Descriptor fd = open_descriptor(path, access, O_DIRECT);
  if (!fd.open()) return direct_failure(path, "", "opening it for direct I/O", errno);
  return std::unique_ptr<DiskFile>(std::make_unique<DirectFile>(path, std::move(fd)));
}

}  // namespace atrium
