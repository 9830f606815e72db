// MachineFile: what the machine's two ways to a file share, mapped and direct: an open descriptor,
// its length, its reservation, its sync, and what an error number says to a user.
//
// Invariant: the descriptor is open as long as the file lives.
// Thread safety: as DiskFile.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "engine/status.h"
#include "pagestore/disk.h"

namespace atrium {

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

std::string byte_place(std::uint64_t offset);
std::string remedy_for(int error);
Status failure(const std::string& path, const std::string& place, const std::string& doing,
               int error);
// A read up to `end` of a file that is only `size` bytes long.
Status ends_early(const std::string& path, std::uint64_t size, std::uint64_t end);

class MachineFile : public DiskFile {
 public:
  const std::string& path() const override { return path_; }
  Result<std::uint64_t> size() const override;
  Status allocate(std::uint64_t size) override;
  Status truncate(std::uint64_t size) override;
  Status sync() override;

 protected:
  MachineFile(std::string path, Descriptor fd) : path_(std::move(path)), fd_(std::move(fd)) {}
  int fd() const { return fd_.get(); }

 private:
  std::string path_;
  Descriptor fd_;
};

// flags: what open(2) takes beside those that follow from `access`. Not open, and errno, on error.
Descriptor open_descriptor(const std::string& path, DiskAccess access, int flags);

// Bytes that all mapped files together may hold of the page cache.
inline constexpr std::uint64_t kMostMapped = std::uint64_t{8} << 20;

Result<std::unique_ptr<DiskFile>> open_mapped(const std::string& path, DiskAccess access);
Result<std::unique_ptr<DiskFile>> open_direct(const std::string& path, DiskAccess access);

}  // namespace atrium
