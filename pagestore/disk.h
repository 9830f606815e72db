// Disk: the few calls that can fail, and nothing else of the machine. The store runs on the
// machine's own disk or, in tests, on a simulated one that tears, fills up and loses power.
//
// The machine's disk has two ways to its files (Io). Mapped: reading goes through read-only
// mappings and is copied out; writing never does: a writable mapping reaches the disk whenever the
// kernel likes, and errors arrive as signals. A mapped page that cannot be read is reported as a
// Status too, not as SIGBUS. What is known to be read, ahead of its request or as a stream,
// comes out of the page cache by pread: there a page need not be mapped for a single copy. Direct:
// past the page cache, in whole granules, several reads at a time.
//
// A failed sync is final: the kernel may have dropped the pages, so it must not be retried.
// Not thread safe; distinct files may be used from distinct threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/status.h"

namespace atrium {

// How the machine's files are read: copied out of read-only mappings, or past the page cache with
// O_DIRECT.
enum class Io { kMmap, kDirect };

// When a read is known: at its request, or before, so that it is announced
// (DiskFile::read_announced).
enum class Known { kNow, kBefore };

class DiskFile {
 public:
  virtual ~DiskFile() = default;
  virtual const std::string& path() const = 0;
  virtual Result<std::uint64_t> size() const = 0;  // bytes

  // Makes the file at least `size` bytes long with every byte of them backed by the disk, so that
  // a full disk shows here. What it held is kept; new bytes are zero.
  virtual Status allocate(std::uint64_t size) = 0;

  // Writes some of the bytes, at least one, and says how many. See write_all. Io::kDirect: offset
  // and length are whole granules.
  virtual Result<std::size_t> write_some(std::uint64_t offset,
                                         std::span<const std::byte> bytes) = 0;

  // Reads all of them; a file that ends before is an error.
  virtual Status read(std::uint64_t offset, std::span<std::byte> bytes) = 0;

  // Advice that this will be read soon, where there is a cache to read it into.
  virtual void will_read(std::uint64_t offset, std::uint64_t length) = 0;

  // As read, of what was announced so.
  virtual Status read_announced(std::uint64_t offset, std::span<std::byte> bytes) {
    return read(offset, bytes);
  }

  virtual Status truncate(std::uint64_t size) = 0;  // what lies beyond is gone

  virtual Status sync() = 0;  // fdatasync: what was written is durable on return
};

Status write_all(DiskFile& file, std::uint64_t offset, std::span<const std::byte> bytes);

// Reads under way, several at a time. The caller numbers them by tickets, of which no two that are
// not waited for are equal. Until a read is waited for, or the queue is gone, its file lives and
// nothing else touches `into`.
class ReadQueue {
 public:
  virtual ~ReadQueue() = default;  // waits for what is under way; what has not begun never does
  virtual const std::string& name() const = 0;  // how it reads, for logs: "io_uring"

  // Any number may be submitted; what is beyond the queue's depth waits its turn in it. `file` is
  // of the disk that made the queue.
  virtual void submit(DiskFile& file, std::uint64_t offset, std::span<std::byte> into,
                      std::uint64_t ticket) = 0;

  // Blocks until that read is done: ok, or what DiskFile::read would have said. In any order.
  virtual Status wait(std::uint64_t ticket) = 0;
};

// Held while it lives; freed by the system whatever becomes of the process.
class DiskLock {
 public:
  virtual ~DiskLock() = default;
};

enum class DiskAccess { kRead, kReadWrite };

class Disk {
 public:
  virtual ~Disk() = default;
  virtual bool exists(const std::string& path) const = 0;
  virtual Status make_directory(const std::string& path) = 0;  // and those above it; may exist
  // kReadWrite makes a file that is missing.
  virtual Result<std::unique_ptr<DiskFile>> open(const std::string& path, DiskAccess access) = 0;
  // depth: reads at a time, at least one.
  virtual std::unique_ptr<ReadQueue> read_queue(unsigned depth) = 0;
  virtual Result<std::uint64_t> free_bytes(const std::string& directory) const = 0;
  virtual Status remove(const std::string& path) = 0;
  // In the place of what is called `to`. After a crash it is the one or the other; durable with
  // sync_directory.
  virtual Status rename(const std::string& from, const std::string& to) = 0;
  virtual Status sync_directory(const std::string& path) = 0;  // files made in it are durable
  // Writes the process id into the lock file. Refuses with the holder's id if it is held.
  virtual Result<std::unique_ptr<DiskLock>> lock(const std::string& path) = 0;
};

// The process that holds the machine's lock at `path`; none if nobody does.
std::optional<long> lock_holder(const std::string& path);

Disk& machine_disk(Io io);

}  // namespace atrium
