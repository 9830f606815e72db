// AppendFile: a new file on a Disk, written from its beginning to its end.
//
// Invariants:
//  1. What stood under its name before is gone.
//  2. The first error is kept: nothing is written after it, and every later call returns it.
// Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "engine/status.h"
#include "pagestore/disk.h"

namespace atrium {

class AppendFile {
 public:
  // kUsage where something else than a plain file has that name: a device, a pipe, a folder.
  static Result<AppendFile> create(const std::string& path, Disk& disk = machine_disk(Io::kMmap));

  Status append(std::span<const std::byte> bytes);
  Status append(const std::string& text);
  Status close();  // durable on return; nothing may be appended after it

  const Status& status() const { return status_; }
  std::uint64_t size() const { return size_; }

 private:
  explicit AppendFile(std::unique_ptr<DiskFile> file) : file_(std::move(file)) {}

  std::unique_ptr<DiskFile> file_;
  std::uint64_t size_ = 0;
  Status status_;
};

}  // namespace atrium
