// Record pieces: plain arrays, one after the other, as the records of one kind, numbered from 0, a
// piece of the whole each: for what is too large to have an image of it beside it in memory. They
// are read back in the order in which they were written. Little endian, as in memory; streamed past
// the arena.
//
// Invariants:
//  1. Beside the caller's arrays a few pieces are in memory, however many there are.
//  2. After finish() the records of this kind are those of this writer, and no others.
// Not thread safe. Errors: kStore.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/status.h"
#include "pagestore/cluster_store.h"

namespace atrium {

// Bytes of payload, so that the record's image is whole granules.
inline constexpr std::size_t kPieceBytes = 64 * kGranule - sizeof(RecordHeader);

class PiecesOut {
 public:
  PiecesOut(ClusterStore& store, RecordKind kind);
  template <class T>
  Status put(std::span<const T> items) {
    return put_bytes(std::as_bytes(items));
  }
  Status finish();

 private:
  Status put_bytes(std::span<const std::byte> bytes);
  Status write_piece();

  ClusterStore& store_;
  RecordKind kind_;
  std::uint64_t next_ = 0;  // the record that the piece will be
  std::vector<std::byte> piece_;
};

// Nothing else is streamed from or to the store meanwhile.
class PiecesIn {
 public:
  PiecesIn(ClusterStore& store, RecordKind kind);
  template <class T>
  Status get(std::vector<T>& items, std::uint64_t count) {
    if (count > left_ / sizeof(T)) return broken();
    items.resize(count);
    return get_bytes(std::as_writable_bytes(std::span(items)));
  }
  // Is that all of it?
  Status finish() const { return left_ == 0 ? Status() : broken(); }

 private:
  Status get_bytes(std::span<std::byte> bytes);
  Status broken() const;

  ClusterStore& store_;
  RecordKind kind_;
  std::uint64_t next_ = 0;  // the record that comes after the piece
  std::uint64_t left_ = 0;  // bytes, of the piece and all after it
  std::span<const std::byte> piece_;
};

bool has_pieces(const ClusterStore& store, RecordKind kind);
void drop_pieces(ClusterStore& store, RecordKind kind);

}  // namespace atrium
