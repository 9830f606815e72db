// What a policy knows of records, by number: arrays that grow as numbers come up, so that nothing
// is hashed and, once the numbers are known, nothing allocated. Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pagestore/policy.h"

namespace atrium {

// A T for every record, T{} at first.
template <class T>
class PerRecord {
 public:
  T& operator[](RecordNumber r) {
    if (r >= values_.size()) values_.resize(r + std::size_t{1});
    return values_[r];
  }

 private:
  std::vector<T> values_;
};

// Records, each in or out; putting in what is in, and taking out what is out, changes nothing.
class RecordSet {
 public:
  bool empty() const { return count_ == 0; }
  bool contains(RecordNumber r) const { return r < in_.size() && in_[r] != 0; }
  void insert(RecordNumber r) {
    if (r >= in_.size()) in_.resize(r + std::size_t{1});
    count_ += in_[r] == 0 ? 1 : 0;
    in_[r] = 1;
  }
  void erase(RecordNumber r) {
    if (!contains(r)) return;
    in_[r] = 0;
    --count_;
  }

 private:
  std::vector<std::uint8_t> in_;
  std::size_t count_ = 0;
};

}  // namespace atrium
