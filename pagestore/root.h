// Root: what a checkpoint comes down to. Two slots of one granule each in the file `roots`, written
// in turn (epoch & 1), so that one that verifies is always left. A root names a directory and a
// state record; they name everything else.
//
// A slot is empty (all zero, never written), whole, or faulty (torn or damaged): FORMAT.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/disk.h"
#include "pagestore/record.h"

namespace atrium {

struct Root {
  std::uint64_t epoch = 0;
  StoreUuid uuid{};
  StoredExtent directory, state;
};

struct RootSlot {
  std::optional<Root> root;  // if whole
  std::string fault;         // if faulty; "" where whole or empty
  bool empty() const { return !root && fault.empty(); }
};

using RootSlots = std::array<RootSlot, 2>;

inline constexpr std::uint64_t kRootFileBytes = 2 * kGranule;

constexpr std::size_t slot_of(std::uint64_t epoch) { return epoch & 1; }

std::vector<std::byte> encode_root(const Root& root);  // one granule
RootSlot decode_root(std::span<const std::byte> granule, std::size_t slot);

// A root file shorter than two slots has empty ones.
Result<RootSlots> read_roots(DiskFile& file);
Status write_root(DiskFile& file, const Root& root);  // and syncs it

}  // namespace atrium
