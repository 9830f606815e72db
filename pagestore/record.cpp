#include "pagestore/record.h"

#include <xxhash.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "engine/check.h"

namespace atrium {

static_assert(std::endian::native == std::endian::little, "the page store is little endian");

namespace {

constexpr const char* kKindNames[kRecordKinds] = {
    "directory", "cluster", "unused", "model", "other", "braids", "equilibrium", "mend", "factors"};

std::uint64_t header_hash_of(const RecordHeader& header) {
  return XXH3_64bits(&header, offsetof(RecordHeader, header_hash));
}

}  // namespace

std::string to_string(RecordId id) {
  const auto kind = static_cast<std::size_t>(kind_of(id));
  const std::string name = kind < kRecordKinds ? kKindNames[kind] : "kind " + std::to_string(kind);
  return name + " " + std::to_string(index_of(id));
}

std::uint64_t hash_bytes(std::span<const std::byte> bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

std::uint64_t seal_record(std::span<std::byte> image, RecordId id, const StoredExtent& extent,
                          const StoreUuid& uuid) {
  ATRIUM_CHECK(image.size() == extent.granules() * kGranule);
  const auto payload = image.subspan(sizeof(RecordHeader), extent.length);
  RecordHeader header{.magic = kRecordMagic,
                      .version = extent.version,
                      .id = id.value,
                      .length = extent.length,
                      .epoch = extent.epoch,
                      .uuid = uuid,
                      .payload_hash = hash_bytes(payload)};
  header.header_hash = header_hash_of(header);
  std::memcpy(image.data(), &header, sizeof header);
  std::ranges::fill(image.subspan(sizeof header + extent.length), std::byte{0});
  return header.header_hash;
}

std::string record_fault(std::span<const std::byte> image, RecordId id, const StoredExtent& extent,
                         const StoreUuid& uuid) {
  ATRIUM_CHECK(image.size() == extent.granules() * kGranule);
  RecordHeader header;
  std::memcpy(&header, image.data(), sizeof header);
  if (header.magic != kRecordMagic) return "its header does not begin with ATR1";
  if (header.header_hash != header_hash_of(header)) return "its header does not match its hash";
  if (header.uuid != uuid) return "it belongs to another store";
  if (header.id != id.value) return "the record there is " + to_string(RecordId{header.id});
  if (header.header_hash != extent.header_hash || header.length != extent.length ||
      header.version != extent.version || header.epoch != extent.epoch)
    return "another version of it lies there (version " + std::to_string(header.version) +
           " of epoch " + std::to_string(header.epoch) + ", not " + std::to_string(extent.version) +
           " of " + std::to_string(extent.epoch) + ")";
  if (hash_bytes(image.subspan(sizeof header, extent.length)) != header.payload_hash)
    return "its payload does not match its hash";
  const auto padding = image.subspan(sizeof header + extent.length);
  if (std::ranges::any_of(padding, [](std::byte b) { return b != std::byte{0}; }))
    return "its padding is not zero";
  return "";
}

}  // namespace atrium
