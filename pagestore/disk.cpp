#include "pagestore/disk.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/interprocess/file_mapping.hpp>
#include <boost/interprocess/mapped_region.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include "engine/check.h"

namespace atrium {

namespace {

namespace bip = boost::interprocess;

constexpr std::uint64_t kPage = 4096;
// The kernel maps up to this much around a page that is touched; giving back less would let the
// resident set grow with the file.
constexpr std::uint64_t kFaultAround = 65536;
constexpr mode_t kFileMode = 0644;

std::string remedy_for(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "make room on that disk and resume";
    case EACCES:
    case EPERM:
    case EROFS:
      return "make it readable and writable for this user";
    case ENOENT:
      return "check the path";
    case EMFILE:
    case ENFILE:
      return "raise the limit of open files";
    default:
      return "check the disk; what the last checkpoint holds is intact";
  }
}

Status failure(const std::string& path, const std::string& place, const std::string& doing,
               int error) {
  return Status(Code::kStore, path, place,
                doing + " failed: " + std::generic_category().message(error), remedy_for(error));
}

std::string byte_place(std::uint64_t offset) { return "byte " + std::to_string(offset); }

// A descriptor closed at the end of its life.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  bool open() const { return fd_ >= 0; }

 private:
  int fd_;
};

template <class Call>
auto retry_interrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

class MachineFile final : public DiskFile {
 public:
  MachineFile(std::string path, Descriptor fd) : path_(std::move(path)), fd_(std::move(fd)) {}

  const std::string& path() const override { return path_; }

  Result<std::uint64_t> size() const override {
    struct stat s;
    if (::fstat(fd_.get(), &s) != 0) return failure(path_, "", "fstat", errno);
    return static_cast<std::uint64_t>(s.st_size);
  }

  Status allocate(std::uint64_t size) override {
    int error = EINTR;  // posix_fallocate returns the error and leaves errno alone
    while (error == EINTR) error = ::posix_fallocate(fd_.get(), 0, static_cast<off_t>(size));
    if (error != 0)
      return failure(path_, "", "reserving " + std::to_string(size) + " bytes", error);
    return {};
  }

  Result<std::size_t> write_some(std::uint64_t offset, std::span<const std::byte> bytes) override {
    const ssize_t written = retry_interrupted([&] {
      return ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(offset));
    });
    if (written < 0) return failure(path_, byte_place(offset), "pwrite", errno);
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

  Status sync() override {
    if (retry_interrupted([&] { return ::fdatasync(fd_.get()); }) != 0)
      return failure(path_, "", "fdatasync", errno);
    return {};
  }

 private:
  std::byte* window() const { return static_cast<std::byte*>(region_.get_address()); }

  // The whole file is one read-only window; its pages are given back after each copy.
  Status map_up_to(std::uint64_t end) {
    const auto bytes = size();
    if (!bytes.ok()) return bytes.status();
    if (*bytes < end)
      return Status(Code::kStore, path_, byte_place(*bytes),
                    "the file ends here, before byte " + std::to_string(end),
                    "restore the file from a copy, or solve again");
    if (region_.get_size() >= end) return {};
    try {
      region_ = bip::mapped_region(bip::file_mapping(path_.c_str(), bip::read_only), bip::read_only,
                                   0, static_cast<std::size_t>(*bytes));
    } catch (const bip::interprocess_exception& e) {
      return failure(path_, "", "mapping it", e.get_native_error());
    }
    ::madvise(region_.get_address(), region_.get_size(), MADV_RANDOM);  // read-ahead is planned
    return {};
  }

  // Brings the pages in now, where an error is a value; touching them would raise SIGBUS.
  Status make_present(std::uint64_t offset, std::uint64_t length) {
    advise(offset, length, MADV_WILLNEED);  // large requests, not a page at a time
    if (advise(offset, length, MADV_POPULATE_READ) == 0) return {};
    if (errno == EINVAL) return {};  // a kernel before 5.14: touching will do
    return failure(path_, byte_place(offset), "reading " + std::to_string(length) + " bytes",
                   errno == EFAULT ? EIO : errno);
  }

  int advise(std::uint64_t offset, std::uint64_t length, int advice) {
    const std::uint64_t begin = offset / kPage * kPage;
    const std::uint64_t end = std::min<std::uint64_t>(offset + length, region_.get_size());
    return retry_interrupted([&] { return ::madvise(window() + begin, end - begin, advice); });
  }

  std::string path_;
  Descriptor fd_;
  bip::mapped_region region_;
};

struct MachineLock final : DiskLock {
  explicit MachineLock(Descriptor held) : fd(std::move(held)) {}
  Descriptor fd;
};

std::string holder_of(int fd) {
  char text[32] = {};
  const ssize_t n = ::pread(fd, text, sizeof text - 1, 0);
  const std::string holder(text, n > 0 ? static_cast<std::size_t>(n) : 0);
  return holder.substr(0, holder.find_first_not_of("0123456789"));
}

class MappedQueue final : public ReadQueue {
 public:
  void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
              std::uint64_t ticket) override {
    file.will_read(offset, into.size());
    reads_[ticket] = {&file, offset, into};
  }
  Status wait(std::uint64_t ticket) override {
    const auto found = reads_.find(ticket);
    ATRIUM_CHECK(found != reads_.end());
    const Read read = found->second;
    reads_.erase(found);
    return read.file->read(read.offset, read.into);
  }

 private:
  struct Read {
    DiskFile* file = nullptr;
    std::uint64_t offset = 0;
    std::span<std::byte> into;
  };
  std::map<std::uint64_t, Read> reads_;
};

class MachineDisk final : public Disk {
 public:
  std::unique_ptr<ReadQueue> read_queue(unsigned) override {
    return std::make_unique<MappedQueue>();
  }

  bool exists(const std::string& path) const override {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
  }

  Status make_directory(const std::string& path) override {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    return error ? failure(path, "", "making the directory", error.value()) : Status();
  }

  Result<std::unique_ptr<DiskFile>> open(const std::string& path, DiskAccess access) override {
    const int flags = access == DiskAccess::kRead ? O_RDONLY : O_RDWR | O_CREAT;
    Descriptor fd(::open(path.c_str(), flags | O_CLOEXEC, kFileMode));
    if (!fd.open()) return failure(path, "", "opening it", errno);
    return std::unique_ptr<DiskFile>(std::make_unique<MachineFile>(path, std::move(fd)));
  }

  Status remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0) return failure(path, "", "removing it", errno);
    return {};
  }

  Status sync_directory(const std::string& path) override {
    Descriptor fd(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!fd.open()) return failure(path, "", "opening the directory", errno);
    if (::fsync(fd.get()) != 0) return failure(path, "", "fsync of the directory", errno);
    return {};
  }

  Result<std::unique_ptr<DiskLock>> lock(const std::string& path) override {
    Descriptor fd(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, kFileMode));
    if (!fd.open()) return failure(path, "", "opening the lock", errno);
    if (retry_interrupted([&] { return ::flock(fd.get(), LOCK_EX | LOCK_NB); }) != 0) {
      if (errno != EWOULDBLOCK) return failure(path, "", "flock", errno);
      return Status(Code::kStore, path, "", "in use by process " + holder_of(fd.get()),
                    "wait for it to end, or stop it");
    }
    const std::string holder = std::to_string(::getpid()) + "\n";
    if (::ftruncate(fd.get(), 0) != 0 ||
        ::pwrite(fd.get(), holder.data(), holder.size(), 0) != std::ssize(holder))
      return failure(path, "", "writing the process id", errno);
    return std::unique_ptr<DiskLock>(std::make_unique<MachineLock>(std::move(fd)));
  }
};

}  // namespace

Status write_all(DiskFile& file, std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto written = file.write_some(offset, bytes);
    if (!written.ok()) return written.status();
    if (*written == 0)
      return Status(Code::kStore, file.path(), byte_place(offset), "a write took no bytes",
                    remedy_for(EIO));
    ATRIUM_CHECK(*written <= bytes.size());
    offset += *written;
    bytes = bytes.subspan(*written);
  }
  return {};
}

Disk& machine_disk(Io) {
  static MachineDisk disk;
  return disk;
}

}  // namespace atrium
