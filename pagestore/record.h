// Record: the unit of the page store, bytes under an opaque id. On disk a record is one extent:
// a 64-byte header, the payload, zeros up to the granule (FORMAT.md). The arena holds the same
// image, so that a read or a write is one copy.
//
// The header binds the payload to its id, its version, the epoch that wrote it and the store it
// belongs to; the directory repeats the header's hash, so that a stale or misdirected extent which
// is whole in itself is found out too.
// Pure functions; safe from any thread.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "pagestore/extent.h"

namespace atrium {

// What a record is for; only counted apart here, never interpreted.
enum class RecordKind : std::uint8_t {
  kDirectory = 0,  // the store's own: directory and state
  kCluster = 1,    // a cluster's solution: read, gathered to, written
  kModel = 3,      // 2 is not used
  kOther = 4,
  kBraids = 5,       // a receiver's links
  kEquilibrium = 6,  // the iteration's coarse system
  kMend = 7,         // what a local pass adds to a cluster's solution
  kFactors = 8       // what is left of the coarse system when the run has ended
};
inline constexpr std::size_t kRecordKinds = 9;

struct RecordId {
  std::uint64_t value = 0;  // kind in the top byte, index below
  friend constexpr auto operator<=>(const RecordId&, const RecordId&) = default;
};

inline constexpr int kKindShift = 56;

constexpr RecordId record_id(RecordKind kind, std::uint64_t index) {
  return {(static_cast<std::uint64_t>(kind) << kKindShift) | index};
}
constexpr RecordKind kind_of(RecordId id) {
  return static_cast<RecordKind>(id.value >> kKindShift);
}
constexpr std::uint64_t index_of(RecordId id) {
  return id.value & ((std::uint64_t{1} << kKindShift) - 1);
}
std::string to_string(RecordId id);  // "cluster 12"

inline constexpr std::size_t kGranule = 4096;  // bytes; extents and arena slots are whole granules

using StoreUuid = std::array<std::byte, 16>;

// The first 64 bytes of every extent, little endian as in memory.
struct RecordHeader {
  std::uint32_t magic = 0;
  std::uint32_t version = 0;  // how often the record was written before
  std::uint64_t id = 0;
  std::uint64_t length = 0;  // bytes of payload
  std::uint64_t epoch = 0;   // the checkpoint it belongs to
  StoreUuid uuid{};
  std::uint64_t payload_hash = 0;  // XXH3-64 of the payload
  std::uint64_t header_hash = 0;   // XXH3-64 of the 56 bytes before
};
static_assert(sizeof(RecordHeader) == 64);

inline constexpr std::uint32_t kRecordMagic = 0x31525441;  // "ATR1"

// Granules of a record's image, header and padding included.
constexpr std::uint64_t granules_of(std::uint64_t payload_bytes) {
  return (sizeof(RecordHeader) + payload_bytes + kGranule - 1) / kGranule;
}

std::uint64_t hash_bytes(std::span<const std::byte> bytes);  // XXH3-64

// A record's image on disk, as last written.
struct StoredExtent {
  std::uint64_t first = kNoGranule;  // page file address
  std::uint64_t length = 0;          // bytes of payload
  std::uint64_t epoch = 0;           // the checkpoint it belongs to
  std::uint64_t header_hash = 0;     // of the header there
  std::uint32_t version = 0;
  bool exists() const { return first != kNoGranule; }
  std::uint64_t granules() const { return granules_of(length); }
};

// Fills in the header of an image (header, payload, padding) and zeros the padding.
// extent.header_hash is not looked at. Returns the header's hash.
std::uint64_t seal_record(std::span<std::byte> image, RecordId id, const StoredExtent& extent,
                          const StoreUuid& uuid);

// What to do about a store that was damaged behind its back.
inline constexpr const char* kDamageRemedy =
    "resume the run (it goes on from the older root if that is whole), restore the run directory "
    "from a copy, or solve again";

// What is wrong with an image that should hold this record; "" if nothing.
std::string record_fault(std::span<const std::byte> image, RecordId id, const StoredExtent& extent,
                         const StoreUuid& uuid);

}  // namespace atrium

template <>
struct std::hash<atrium::RecordId> {
  std::size_t operator()(const atrium::RecordId& id) const noexcept {
    return static_cast<std::size_t>(id.value * 0x9e3779b97f4a7c15u);  // spreads the kinds apart
  }
};
