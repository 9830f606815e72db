#include "scheduler/record_pieces.h"

#include <algorithm>

namespace atrium {

namespace {

void drop_from(ClusterStore& store, RecordKind kind, std::uint64_t first) {
  for (std::uint64_t i = first; store.contains(record_id(kind, i)); ++i)
    store.drop_streamed(record_id(kind, i));
}

}  // namespace

PiecesOut::PiecesOut(ClusterStore& store, RecordKind kind) : store_(store), kind_(kind) {
  piece_.reserve(kPieceBytes);
}

Status PiecesOut::put_bytes(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    if (piece_.size() == kPieceBytes) ATRIUM_RETURN_IF_ERROR(write_piece());
    const std::size_t count = std::min(bytes.size(), kPieceBytes - piece_.size());
    piece_.insert(piece_.end(), bytes.begin(), bytes.begin() + std::ptrdiff_t(count));
    bytes = bytes.subspan(count);
  }
  return {};
}

Status PiecesOut::write_piece() {
  ATRIUM_RETURN_IF_ERROR(store_.stream_out(record_id(kind_, next_), piece_));
  ++next_;
  piece_.clear();
  return {};
}

Status PiecesOut::finish() {
  ATRIUM_RETURN_IF_ERROR(write_piece());
  drop_from(store_, kind_, next_);
  return {};
}

PiecesIn::PiecesIn(ClusterStore& store, RecordKind kind) : store_(store), kind_(kind) {
  for (std::uint64_t i = 0; store.contains(record_id(kind, i)); ++i)
    left_ += store.size(record_id(kind, i));
}

Status PiecesIn::get_bytes(std::span<std::byte> bytes) {
  while (!bytes.empty()) {
    if (piece_.empty()) {
      const auto piece = store_.stream_in(record_id(kind_, next_));
      if (!piece.ok()) return piece.status();
      piece_ = *piece;
      ++next_;
    }
    const std::size_t count = std::min(bytes.size(), piece_.size());
    std::ranges::copy(piece_.first(count), bytes.begin());
    bytes = bytes.subspan(count);
    piece_ = piece_.subspan(count);
    left_ -= count;
  }
  return {};
}

Status PiecesIn::broken() const {
  return Status(Code::kStore, "", to_string(record_id(kind_, 0)),
                "its length is not what it says it holds", "run atrium check on the run");
}

bool has_pieces(const ClusterStore& store, RecordKind kind) {
  return store.contains(record_id(kind, 0));
}

void drop_pieces(ClusterStore& store, RecordKind kind) { drop_from(store, kind, 0); }

}  // namespace atrium
