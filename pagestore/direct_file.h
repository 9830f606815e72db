// DirectFile: a file read and written past the page cache (O_DIRECT), in whole granules from
// aligned memory. What is not aligned goes through a bounce buffer that lives for the call: roots,
// directories and states, a few a checkpoint.
//
// Invariants:
//  1. Every request to the kernel is of whole granules, from memory aligned to them.
//  2. What write_some says was written is whole granules: the rest of a torn one is written again.
// Thread safety: read may be called from several threads at once; it keeps nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "pagestore/machine_file.h"

namespace atrium {

class DirectFile final : public MachineFile {
 public:
  DirectFile(std::string path, Descriptor fd) : MachineFile(std::move(path), std::move(fd)) {}

  // Offset and length are whole granules.
  Result<std::size_t> write_some(std::uint64_t offset, std::span<const std::byte> bytes) override;
  Status read(std::uint64_t offset, std::span<std::byte> bytes) override;
  void will_read(std::uint64_t, std::uint64_t) override {}  // there is no cache to read into

  // Can a read be handed to the kernel as it is?
  static bool aligned(std::uint64_t offset, std::span<const std::byte> bytes);

  int descriptor() const { return fd(); }
  Status failed_read(std::uint64_t offset, int error) const;

 private:
  Result<std::size_t> write_granules(std::uint64_t offset, std::span<const std::byte> bytes);
  Status read_granules(std::uint64_t offset, std::span<std::byte> bytes, std::size_t enough);
};

}  // namespace atrium
