#include "pagestore/directory.h"

#include <algorithm>
#include <cstring>

namespace atrium {

DirectoryEntry entry_of(RecordId id, const StoredExtent& extent) {
  return {.id = id.value,
          .length = extent.length,
          .epoch = extent.epoch,
          .header_hash = extent.header_hash,
          .first = extent.first,
          .version = extent.version};
}

StoredExtent extent_of(const DirectoryEntry& entry) {
  return {.first = entry.first,
          .length = entry.length,
          .epoch = entry.epoch,
          .header_hash = entry.header_hash,
          .version = entry.version};
}

Result<std::vector<DirectoryEntry>> decode_directory(std::span<const std::byte> payload,
                                                     const std::string& path) {
  const auto fault = [&](const std::string& cause) {
    return Status(Code::kStore, path, "directory", cause, kDamageRemedy);
  };
  if (payload.size() % sizeof(DirectoryEntry) != 0)
    return fault("it is not a whole number of entries");
  std::vector<DirectoryEntry> entries(payload.size() / sizeof(DirectoryEntry));
  if (!payload.empty()) std::memcpy(entries.data(), payload.data(), payload.size());
  const auto out_of_order = [](const auto& a, const auto& b) { return a.id >= b.id; };
  if (std::ranges::adjacent_find(entries, out_of_order) != entries.end())
    return fault("its entries are not in the order of their ids");
  for (const DirectoryEntry& entry : entries)
    if (entry.id >> kKindShift >= kRecordKinds) return fault("an entry is of no known kind");
  return entries;
}

}  // namespace atrium
