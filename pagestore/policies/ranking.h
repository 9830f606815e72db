// Ranking: records by a key, the least first: a binary heap that knows where each record stands.
// Placing and erasing take logarithmic time and, once the numbers are known, allocate nothing.
//
// 1. heap_[(i - 1) / 2].key <= heap_[i].key.
// 2. place_[heap_[i].record] == i + 1; 0 for records that are not ranked.
// Not thread safe.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "engine/check.h"
#include "pagestore/policies/records.h"
#include "pagestore/policy.h"

namespace atrium {

template <class Key>
class Ranking {
 public:
  bool contains(RecordNumber r) { return place_[r] != 0; }
  std::optional<RecordNumber> first() const {
    return heap_.empty() ? std::nullopt : std::optional(heap_.front().record);
  }

  void insert(RecordNumber r, Key key) {
    ATRIUM_CHECK(!contains(r));
    heap_.push_back({key, r});
    rise(heap_.size() - 1);
  }

  void erase(RecordNumber r) {
    ATRIUM_CHECK(contains(r));
    const std::size_t hole = place_[r] - 1;
    place_[r] = 0;
    const Entry last = heap_.back();
    heap_.pop_back();
    if (hole == heap_.size()) return;
    heap_[hole] = last;
    rise(hole);
    sink(place_[last.record] - 1);
  }

 private:
  struct Entry {
    Key key;
    RecordNumber record;
  };

  void put(std::size_t at, const Entry& entry) {
    heap_[at] = entry;
    place_[entry.record] = at + 1;
  }

  void rise(std::size_t at) {
    const Entry entry = heap_[at];
    for (; at > 0 && entry.key < heap_[(at - 1) / 2].key; at = (at - 1) / 2)
      put(at, heap_[(at - 1) / 2]);
    put(at, entry);
  }

  void sink(std::size_t at) {
    const Entry entry = heap_[at];
    for (std::size_t child; (child = lesser_child(at)) < heap_.size(); at = child) {
      if (!(heap_[child].key < entry.key)) break;
      put(at, heap_[child]);
    }
    put(at, entry);
  }

  std::size_t lesser_child(std::size_t at) const {
    const std::size_t left = 2 * at + 1;
    return left + 1 < heap_.size() && heap_[left + 1].key < heap_[left].key ? left + 1 : left;
  }

  std::vector<Entry> heap_;
  PerRecord<std::size_t> place_;
};

}  // namespace atrium
