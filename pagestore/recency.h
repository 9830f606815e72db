// Recency: records in the order in which they were last pushed, and how many bytes lie above each:
// the stack of an LRU arena. [Mattson, Gecsei, Slutz, Traiger 1970]
//
// Every push gives the next stamp; sums over stamps are kept in a tree of kFanout children a node,
// each level a flat array. A level holds prefix sums within its nodes: to look up is one load a
// level, to remove one vector loop a level, and to push mostly nothing, as nothing comes after it.
//
// Invariants:
//  1. level 0: entry s is the bytes of stamps up to s, from the first of its node on. Level k > 0:
//     entry i is the bytes of what lies under those before it in its node. Entries beyond the last
//     stamp given hold nothing of meaning.
//  2. A record has one stamp at most. When stamps run out, those in use are numbered anew.
// Not thread safe.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "pagestore/policy.h"

namespace atrium {

class Recency {
 public:
  using Bytes = std::uint64_t;

  explicit Recency(std::size_t records)
      : places_(records), capacity_(round_up(kStampsPerRecord * records)), pushed_(capacity_) {
    for (std::size_t entries = capacity_; entries > 1; entries = round_up(entries) / kFanout)
      levels_.emplace_back(round_up(entries));
  }

  bool holds(RecordNumber record) const { return places_[record].stamp != kNone; }
  Bytes total() const { return total_; }

  // The bytes of a record that is there, and of those pushed after it.
  Bytes from_top(RecordNumber record) const {
    const Place place = places_[record];
    return total_ - up_to(place.stamp) + place.bytes;
  }

  // The record is not there.
  void push(RecordNumber record, Bytes bytes) {
    if (next_ == capacity_) renumber();
    append(record, bytes);
    total_ += bytes;
  }

  // The record is there.
  void remove(RecordNumber record) {
    Place& place = places_[record];
    std::size_t index = place.stamp;
    subtract_from(levels_[0], index, index % kFanout, place.bytes);
    for (std::size_t level = 1; level < levels_.size(); ++level) {
      index /= kFanout;
      subtract_from(levels_[level], index, index % kFanout + 1, place.bytes);
    }
    total_ -= place.bytes;
    place.stamp = kNone;
  }

 private:
  using Stamp = std::uint32_t;
  using Level = std::vector<Bytes>;
  struct Place {
    Bytes bytes = 0;
    Stamp stamp = kNone;
  };
  static constexpr Stamp kNone = std::numeric_limits<Stamp>::max();
  static constexpr std::size_t kFanout = 64;
  static constexpr std::size_t kStampsPerRecord = 2;  // renumbering costs a push about one more

  static std::size_t round_up(std::size_t entries) {
    return std::max<std::size_t>(1, (entries + kFanout - 1) / kFanout) * kFanout;
  }

  // A loop of fixed length, for the compiler to make vectors of.
  static void subtract_from(Level& level, std::size_t index, std::size_t first, Bytes bytes) {
    Bytes* const node = &level[index / kFanout * kFanout];
    for (std::size_t i = 0; i < kFanout; ++i) node[i] -= i >= first ? bytes : 0;
  }

  Bytes up_to(Stamp stamp) const {
    Bytes sum = 0;
    std::size_t index = stamp;
    for (const Level& level : levels_) {
      sum += level[index];
      index /= kFanout;
    }
    return sum;
  }

  void append(RecordNumber record, Bytes bytes) {
    if (next_ % kFanout == 0) begin_node();
    const Bytes before = next_ % kFanout == 0 ? 0 : levels_[0][next_ - 1];
    levels_[0][next_] = before + bytes;
    pushed_[next_] = record;
    places_[record] = {bytes, next_++};
  }

  // The next stamp is the first of its node: what the nodes before it hold becomes known above.
  void begin_node() {
    Bytes before = next_ == 0 ? 0 : levels_[0][next_ - 1];
    std::size_t index = next_;
    for (std::size_t level = 1; level < levels_.size(); ++level) {
      index /= kFanout;
      const bool first = index % kFanout == 0;
      const Bytes left = index == 0 ? 0 : levels_[level][index - 1];
      levels_[level][index] = first ? 0 : left + before;
      if (!first) return;
      before += left;
    }
  }

  void renumber() {
    const Stamp given = next_;
    next_ = 0;
    for (Stamp stamp = 0; stamp < given; ++stamp) {
      const RecordNumber record = pushed_[stamp];
      if (places_[record].stamp == stamp) append(record, places_[record].bytes);
    }
  }

  std::vector<Place> places_;  // by record
  std::size_t capacity_;       // stamps
  std::vector<RecordNumber> pushed_;
  std::vector<Level> levels_;
  Stamp next_ = 0;
  Bytes total_ = 0;
};

}  // namespace atrium
