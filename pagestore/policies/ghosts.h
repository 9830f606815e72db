// Ghosts: records that left the arena not long ago, remembered without their bytes, first in first
// out, as many as would fit into a capacity.
// Not thread safe.
#pragma once

#include <cstdint>

#include "pagestore/policies/queue.h"

namespace atrium {

class Ghosts {
 public:
  explicit Ghosts(std::uint64_t capacity) : capacity_(capacity) {}

  // What is larger than the capacity is not remembered, and makes nobody forgotten.
  void remember(RecordNumber r, std::uint64_t bytes) {
    if (bytes > capacity_) return;
    while (row_.bytes() + bytes > capacity_) row_.erase(*row_.front());
    row_.push_back(r, bytes);
  }
  // Was it remembered?
  bool forget(RecordNumber r) {
    if (!row_.contains(r)) return false;
    row_.erase(r);
    return true;
  }

 private:
  SizedQueue row_;  // longest remembered first
  std::uint64_t capacity_;
};

}  // namespace atrium
