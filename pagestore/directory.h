// Directory: what the store knows of every record. In memory a StoredRecord per record, with its
// place on disk and in the arena; on disk a row of DirectoryEntry, sorted by id, written whole at
// each checkpoint (FORMAT.md). The free maps of page file and arena are never stored: they are
// what the directory does not name.
// Plain data; no thread safety of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/extent.h"
#include "pagestore/policy.h"
#include "pagestore/record.h"

namespace atrium {

struct StoredRecord {
  RecordId id;
  RecordNumber number = 0;     // what the policy calls it
  StoredExtent on_disk;        // behind the arena's image while dirty; then it may not exist
  Run claim;                   // on disk, where it will be written next; of dirty ones
  std::uint32_t version = 0;   // how often it was written
  std::uint64_t length = 0;    // bytes of payload now
  std::uint64_t slot = kNoGranule;  // first granule in the arena
  std::uint32_t pins = 0;
  bool dirty = false;
  bool coming = false;  // its slot is being read into ahead of its request
  bool exists() const { return slot != kNoGranule || on_disk.exists(); }  // else dropped
  bool resident() const { return slot != kNoGranule && !coming; }
  std::uint64_t granules() const { return granules_of(length); }
};

struct DirectoryEntry {
  std::uint64_t id = 0;
  std::uint64_t length = 0;
  std::uint64_t epoch = 0;
  std::uint64_t header_hash = 0;
  std::uint64_t first = 0;
  std::uint32_t version = 0;
  std::uint32_t reserved = 0;
};
static_assert(sizeof(DirectoryEntry) == 48);

DirectoryEntry entry_of(RecordId id, const StoredExtent& extent);
StoredExtent extent_of(const DirectoryEntry& entry);

// The entries in a directory record's payload, sorted by id without repetition, or what is wrong
// with it.
Result<std::vector<DirectoryEntry>> decode_directory(std::span<const std::byte> payload,
                                                     const std::string& path);

}  // namespace atrium
