// Queue: records in a doubly linked row, by number; a record stands in a Queue at most once.
// SizedQueue: the same, knowing its records' sizes and their sum. Every operation takes constant
// time and, once the numbers are known, allocates nothing.
// Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "engine/check.h"
#include "pagestore/policies/records.h"
#include "pagestore/policy.h"

namespace atrium {

class Queue {
 public:
  bool empty() const { return front_ == kNone; }
  bool contains(RecordNumber r) const { return r < links_.size() && links_[r].in; }
  std::optional<RecordNumber> front() const { return some(front_); }
  std::optional<RecordNumber> after(RecordNumber r) const { return some(links_[r].after); }

  void push_back(RecordNumber r) {
    make_known(r);
    ATRIUM_CHECK(!links_[r].in);
    links_[r] = {back_, kNone, true};
    (back_ == kNone ? front_ : links_[back_].after) = r;
    back_ = r;
  }

  void push_front(RecordNumber r) {
    make_known(r);
    ATRIUM_CHECK(!links_[r].in);
    links_[r] = {kNone, front_, true};
    (front_ == kNone ? back_ : links_[front_].before) = r;
    front_ = r;
  }

  void erase(RecordNumber r) {
    ATRIUM_CHECK(contains(r));
    const Link link = links_[r];
    (link.before == kNone ? front_ : links_[link.before].after) = link.after;
    (link.after == kNone ? back_ : links_[link.after].before) = link.before;
    links_[r] = {};
  }

  void move_to_back(RecordNumber r) {
    if (r == back_) return;
    erase(r);
    push_back(r);
  }

 private:
  static constexpr RecordNumber kNone = std::numeric_limits<RecordNumber>::max();
  struct Link {
    RecordNumber before = kNone, after = kNone;
    bool in = false;
  };
  static std::optional<RecordNumber> some(RecordNumber r) {
    return r == kNone ? std::nullopt : std::optional(r);
  }
  void make_known(RecordNumber r) {
    if (r >= links_.size()) links_.resize(r + std::size_t{1});
  }

  std::vector<Link> links_;
  RecordNumber front_ = kNone, back_ = kNone;
};

class SizedQueue {
 public:
  bool empty() const { return order_.empty(); }
  bool contains(RecordNumber r) const { return order_.contains(r); }
  std::optional<RecordNumber> front() const { return order_.front(); }
  std::optional<RecordNumber> after(RecordNumber r) const { return order_.after(r); }
  std::uint64_t bytes() const { return bytes_; }
  std::uint64_t size_of(RecordNumber r) { return sizes_[r]; }

  void push_back(RecordNumber r, std::uint64_t bytes) {
    order_.push_back(r);
    weigh(r, bytes);
  }
  void push_front(RecordNumber r, std::uint64_t bytes) {
    order_.push_front(r);
    weigh(r, bytes);
  }
  void move_to_back(RecordNumber r) { order_.move_to_back(r); }
  void resize(RecordNumber r, std::uint64_t bytes) {
    bytes_ -= sizes_[r];
    weigh(r, bytes);
  }
  // Returns its size.
  std::uint64_t erase(RecordNumber r) {
    order_.erase(r);
    const std::uint64_t size = size_of(r);
    bytes_ -= size;
    return size;
  }

 private:
  void weigh(RecordNumber r, std::uint64_t bytes) {
    sizes_[r] = bytes;
    bytes_ += bytes;
  }

  Queue order_;
  PerRecord<std::uint64_t> sizes_;
  std::uint64_t bytes_ = 0;
};

// The first in a queue that is not pinned.
template <class AnyQueue>
std::optional<RecordNumber> first_released(const AnyQueue& queue, const RecordSet& released) {
  auto r = queue.front();
  while (r && !released.contains(*r)) r = queue.after(*r);
  return r;
}

}  // namespace atrium
