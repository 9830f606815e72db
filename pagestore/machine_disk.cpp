// The machine's own disk, in its two ways: directories, locks, and which files and queues are
// opened.
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <system_error>
#include <thread>

#include "engine/check.h"
#include "pagestore/machine_file.h"
#include "pagestore/read_queue.h"

namespace atrium {

namespace {

struct MachineLock final : DiskLock {
  explicit MachineLock(Descriptor held) : fd(std::move(held)) {}
  Descriptor fd;
};

// Somebody may only be asking who holds it: that takes no time.
bool take_lock(int fd) {
  constexpr int kAttempts = 5;
  constexpr std::chrono::milliseconds kBetween{5};
  for (int attempt = 1;; ++attempt) {
    if (retry_interrupted([&] { return ::flock(fd, LOCK_EX | LOCK_NB); }) == 0) return true;
    if (errno != EWOULDBLOCK || attempt == kAttempts) return false;
    std::this_thread::sleep_for(kBetween);
  }
}

std::string holder_of(int fd) {
  char text[32] = {};
  const ssize_t n = ::pread(fd, text, sizeof text - 1, 0);
  const std::string holder(text, n > 0 ? static_cast<std::size_t>(n) : 0);
  return holder.substr(0, holder.find_first_not_of("0123456789"));
}

class MachineDisk : public Disk {
 public:
  bool exists(const std::string& path) const override {
    std::error_code ignored;
    return std::filesystem::exists(path, ignored);
  }

  Status make_directory(const std::string& path) override {
    std::error_code error;
    std::filesystem::create_directories(path, error);
    return error ? failure(path, "", "making the directory", error.value()) : Status();
  }

  Result<std::uint64_t> free_bytes(const std::string& directory) const override {
    std::error_code error;
    const auto space = std::filesystem::space(directory, error);
    if (error) return failure(directory, "", "asking for its free space", error.value());
    return std::uint64_t{space.available};
  }

  Status remove(const std::string& path) override {
    if (::unlink(path.c_str()) != 0) return failure(path, "", "removing it", errno);
    return {};
  }

  Status rename(const std::string& from, const std::string& to) override {
    if (::rename(from.c_str(), to.c_str()) != 0)
      return failure(from, "", "renaming it to " + to, errno);
    return {};
  }

  Status sync_directory(const std::string& path) override {
    Descriptor fd(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    if (!fd.open()) return failure(path, "", "opening the directory", errno);
    if (::fsync(fd.get()) != 0) return failure(path, "", "fsync of the directory", errno);
    return {};
  }

  Result<std::unique_ptr<DiskLock>> lock(const std::string& path) override {
    Descriptor fd = open_descriptor(path, DiskAccess::kReadWrite, 0);
    if (!fd.open()) return failure(path, "", "opening the lock", errno);
    if (!take_lock(fd.get())) {
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

class MappedDisk final : public MachineDisk {
 public:
  Result<std::unique_ptr<DiskFile>> open(const std::string& path, DiskAccess access) override {
    return open_mapped(path, access);
  }
  std::unique_ptr<ReadQueue> read_queue(unsigned) override { return make_advising_queue(); }
};

class DirectDisk final : public MachineDisk {
 public:
  Result<std::unique_ptr<DiskFile>> open(const std::string& path, DiskAccess access) override {
    return open_direct(path, access);
  }
  std::unique_ptr<ReadQueue> read_queue(unsigned depth) override {
    ATRIUM_CHECK(depth > 0);
    auto queue = make_uring_queue(depth);
    return queue.ok() ? std::move(queue).value() : make_thread_queue(queue.status().cause());
  }
};

}  // namespace

std::optional<long> lock_holder(const std::string& path) {
  const Descriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!fd.open()) return std::nullopt;
  if (retry_interrupted([&] { return ::flock(fd.get(), LOCK_SH | LOCK_NB); }) == 0)
    return std::nullopt;
  const std::string holder = holder_of(fd.get());
  return holder.empty() ? std::nullopt : std::optional(std::stol(holder));
}

Disk& machine_disk(Io io) {
  static MappedDisk mapped;
  static DirectDisk direct;
  if (io == Io::kDirect) return direct;
  return mapped;
}

}  // namespace atrium
