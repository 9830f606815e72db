// A file read through a read-only mapping: copied out, and the pages given back before they are
// many. Writing never goes through a mapping, nor does what was announced: mapping pages for one
// copy took five times as long as a pread from the page cache, where memory is virtual twice.
//
// Giving back interrupts all processors that may know of the pages: for each record by itself it
// was four fifths of what reading took [Crotty, Leis & Pavlo 22 §3.2, TLB shootdowns]. So it is
// done for all files at once, each time that kMostMapped are resident.
#include <sys/mman.h>

#include <algorithm>
#include <atomic>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cstring>
#include <mutex>
#include <set>
#include <shared_mutex>

#include "pagestore/machine_file.h"

namespace atrium {

namespace {

namespace bip = boost::interprocess;

constexpr std::uint64_t kPage = 4096;
// The kernel maps up to this much around a page that is touched.
constexpr std::uint64_t kFaultAround = 65536;

class MappedFile;

// What mapped files hold of the page cache. Shared while one copies, exclusive while pages go: what
// has been made present stays so until it is copied.
class MappedPages {
 public:
  void enter(MappedFile& file);
  void leave(MappedFile& file);
  std::shared_lock<std::shared_mutex> copying() { return std::shared_lock(mutex_); }
  void touched(std::uint64_t bytes);

 private:
  std::shared_mutex mutex_;
  std::set<MappedFile*> files_;
  std::atomic<std::uint64_t> bytes_ = 0;  // at most, of all
};

MappedPages& mapped_pages() {
  static MappedPages pages;
  return pages;
}

class MappedFile final : public MachineFile {
 public:
  MappedFile(std::string path, Descriptor fd) : MachineFile(std::move(path), std::move(fd)) {
    mapped_pages().enter(*this);
  }
  ~MappedFile() override { mapped_pages().leave(*this); }

  Result<std::size_t> write_some(std::uint64_t offset, std::span<const std::byte> bytes) override {
    const ssize_t written = retry_interrupted(
        [&] { return ::pwrite(fd(), bytes.data(), bytes.size(), static_cast<off_t>(offset)); });
    if (written < 0) return failure(path(), byte_place(offset), "pwrite", errno);
    return static_cast<std::size_t>(written);
  }

  Status read(std::uint64_t offset, std::span<std::byte> bytes) override {
    if (bytes.empty()) return {};
    {
      const auto copying = mapped_pages().copying();
      ATRIUM_RETURN_IF_ERROR(map_up_to(offset + bytes.size()));
      ATRIUM_RETURN_IF_ERROR(make_present(offset, bytes.size()));
      std::memcpy(bytes.data(), window() + offset, bytes.size());
    }
    mapped_pages().touched(kFaultAround + bytes.size() + kFaultAround);
    return {};
  }

  Status read_announced(std::uint64_t offset, std::span<std::byte> bytes) override {
    for (std::size_t done = 0; done < bytes.size();) {
      const std::span<std::byte> rest = bytes.subspan(done);
      const ssize_t got = retry_interrupted([&] {
        return ::pread(fd(), rest.data(), rest.size(), static_cast<off_t>(offset + done));
      });
      if (got < 0)
        return failure(path(), byte_place(offset + done),
                       "reading " + std::to_string(rest.size()) + " bytes", errno);
      if (got == 0) return ends_early(path(), offset + done, offset + bytes.size());
      done += static_cast<std::size_t>(got);
    }
    return {};
  }

  void give_back() {
    if (region_.get_size() > 0) advise(0, region_.get_size(), MADV_DONTNEED);
  }

  void will_read(std::uint64_t offset, std::uint64_t length) override {
    const auto copying = mapped_pages().copying();
    if (map_up_to(offset + length).ok()) advise(offset, length, MADV_WILLNEED);
  }

 private:
  std::byte* window() const { return static_cast<std::byte*>(region_.get_address()); }

  // The whole file is one read-only window.
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

void MappedPages::enter(MappedFile& file) {
  const std::unique_lock lock(mutex_);
  files_.insert(&file);
}

void MappedPages::leave(MappedFile& file) {
  const std::unique_lock lock(mutex_);
  files_.erase(&file);
}

void MappedPages::touched(std::uint64_t bytes) {
  if ((bytes_ += bytes) < kMostMapped) return;
  const std::unique_lock lock(mutex_);
  for (MappedFile* file : files_) file->give_back();
  bytes_ = 0;
}

}  // namespace

Result<std::unique_ptr<DiskFile>> open_mapped(const std::string& path, DiskAccess access) {
  Descriptor fd = open_descriptor(path, access, 0);
  if (!fd.open()) return failure(path, "", "opening it", errno);
  return std::unique_ptr<DiskFile>(std::make_unique<MappedFile>(path, std::move(fd)));
}

}  // namespace atrium
