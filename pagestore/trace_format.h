// The bytes of an .atr file, as its writer and its reader share them (TRACE.md).
//
// A file is a header and chunks; the last chunk of a file that was closed is empty. An event is a
// varint that holds its kind and, zigzag, how far its record's number lies from that of the event
// before; what else it needs follows as varints.
// Plain data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace atrium::trace_format {

inline constexpr std::string_view kMagic = "ATRTRACE";
inline constexpr std::uint32_t kFormat = 1;

struct FileHeader {
  std::array<char, 8> magic{'A', 'T', 'R', 'T', 'R', 'A', 'C', 'E'};
  std::uint32_t format = kFormat;
  std::uint32_t zero = 0;
};
static_assert(sizeof(FileHeader) == 16);

// The payload follows. Its hash covers the eight bytes before it too, while the hash of the chunk
// before stands there: a chunk that is whole in itself but out of its place is found out.
struct ChunkHeader {
  std::uint32_t length = 0;        // bytes of payload
  std::uint32_t events = 0;        // as a Trace counts them: a visit is two
  std::uint64_t payload_hash = 0;  // XXH3-64 of the last chunk's header_hash (0) and the payload
  std::uint64_t header_hash = 0;   // XXH3-64 of the 16 bytes before
};
static_assert(sizeof(ChunkHeader) == 24);

inline constexpr std::size_t kLargestChunk = 65536;  // bytes of payload

enum class Kind : std::uint8_t {
  kRead = 0,
  kVisit = 1,  // read and released at once
  kDirty = 2,  // then: by how much it grew, zigzag
  kRelease = 3,
  kCreate = 4,  // of a record not seen before
  kGather = 5,
  kIteration = 6,   // of no record; then: its number
  kCheckpoint = 7,  // of no record
};
inline constexpr int kKindBits = 3;
inline constexpr std::uint64_t kKindMask = (1u << kKindBits) - 1;

constexpr bool is_mark(Kind kind) { return kind == Kind::kIteration || kind == Kind::kCheckpoint; }

// Signed numbers near zero as small unsigned ones: 0, -1, 1, -2, ... Differences of 64-bit numbers
// wrap around.
constexpr std::uint64_t zigzag(std::uint64_t difference) {
  return (difference << 1) ^ (0 - (difference >> 63));
}
constexpr std::uint64_t unzigzag(std::uint64_t code) { return (code >> 1) ^ (0 - (code & 1)); }

// Seven bits a byte, the lowest first; the top bit says that more follow.
inline constexpr int kVarintBits = 7;
inline constexpr std::uint64_t kVarintMask = 0x7f;
inline constexpr std::uint64_t kVarintMore = 0x80;
inline constexpr std::size_t kLongestVarint = 10;  // bytes

// Kind and number, id, size.
inline constexpr std::size_t kLongestEvent = 3 * kLongestVarint;

}  // namespace atrium::trace_format
