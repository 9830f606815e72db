// A file read through read-only mappings: copied out, and the pages given back at once. Writing
// never goes through a mapping.
#include <sys/mman.h>

#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cstring>

#include "pagestore/machine_file.h"

namespace atrium {

namespace {

namespace bip = boost::interprocess;

constexpr std::uint64_t kPage = 4096;
// The kernel maps up to this much around a page that is touched; giving back less would let the
// resident set grow with the file.
constexpr std::uint64_t kFaultAround = 65536;

class MappedFile final : public MachineFile {
 public:
  MappedFile(std::string path, Descriptor fd) : MachineFile(std::move(path), std::move(fd)) {}

  Result<std::size_t> write_some(std::uint64_t offset, std::span<const std::byte> bytes) override {
    const ssize_t written = retry_interrupted(
        [&] { return ::pwrite(fd(), bytes.data(), bytes.size(), static_cast<off_t>(offset)); });
    if (written < 0) return failure(path(), byte_place(offset), "pwrite", errno);
    return static_cast<std::size_t>(written);
  }

  Status read(std::uint64_t offset, std::span<std::byte> bytes) override {
    if (bytes.empty()) return {};
    ATRIUM_RETURN_IF_ERROR(map_up_to(offset + bytes.size()));
    ATRIUM_RETURN_IF_ERROR(make_present(offset, bytes.size()));
    std::memcpy(bytes.data(), window() + offset, bytes.size());
    const std::uint64_t before = std::min(offset, kFaultAround);
    advise(offset - before, before + bytes.size() + kFaultAround, MADV_DONTNEED);
    return {};
  }

  void will_read(std::uint64_t offset, std::uint64_t length) override {
    if (map_up_to(offset + length).ok()) advise(offset, length, MADV_WILLNEED);
  }

 private:
  std::byte* window() const { return static_cast<std::byte*>(region_.get_address()); }

  // The whole file is one read-only window; its pages are given back after each copy.
  Status map_up_to(std::uint64_t end) {
    const auto bytes = size();
    if (!bytes.ok()) return bytes.status();
    if (*bytes < end) return ends_early(path(), *bytes, end);
    if (region_.get_size() >= end) return {};
    try {
      region_ = bip::mapped_region(bip::file_mapping(path().c_str(), bip::read_only),
                                   bip::read_only, 0, static_cast<std::size_t>(*bytes));
    } catch (const bip::interprocess_exception& e) {
      return failure(path(), "", "mapping it", e.get_native_error());
    }
    ::madvise(region_.get_address(), region_.get_size(), MADV_RANDOM);  // read-ahead is planned
    return {};
  }

  // Brings the pages in now, where an error is a value; touching them would raise SIGBUS.
  Status make_present(std::uint64_t offset, std::uint64_t length) {
    advise(offset, length, MADV_WILLNEED);  // large requests, not a page at a time
    if (advise(offset, length, MADV_POPULATE_READ) == 0) return {};
    if (errno == EINVAL) return {};  // a kernel before 5.14: touching will do
    return failure(path(), byte_place(offset), "reading " + std::to_string(length) + " bytes",
                   errno == EFAULT ? EIO : errno);
  }

  int advise(std::uint64_t offset, std::uint64_t length, int advice) {
    const std::uint64_t begin = offset / kPage * kPage;
    const std::uint64_t end = std::min<std::uint64_t>(offset + length, region_.get_size());
    return retry_interrupted([&] { return ::madvise(window() + begin, end - begin, advice); });
  }

  bip::mapped_region region_;
};

}  // namespace

Result<std::unique_ptr<DiskFile>> open_mapped(const std::string& path, DiskAccess access) {
  Descriptor fd = open_descriptor(path, access, 0);
  if (!fd.open()) return failure(path, "", "opening it", errno);
  return std::unique_ptr<DiskFile>(std::make_unique<MappedFile>(path, std::move(fd)));
}

}  // namespace atrium
