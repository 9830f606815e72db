// Queue: records in a doubly linked row, by number; a record stands in a Queue at most once. Every
// operation takes constant time and, once the numbers are known, allocates nothing.
// Not thread safe.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "engine/check.h"
#include "pagestore/policy.h"

namespace atrium {

class Queue {
 public:
  bool empty() const { return front_ == kNone; }
  bool contains(RecordNumber r) const { return r < links_.size() && links_[r].in; }
  std::optional<RecordNumber> front() const { return some(front_); }
  std::optional<RecordNumber> back() const { return some(back_); }
  std::optional<RecordNumber> after(RecordNumber r) const { return some(links_[r].after); }
  std::optional<RecordNumber> before(RecordNumber r) const { return some(links_[r].before); }

  void push_back(RecordNumber r) {
    make_known(r);
    ATRIUM_CHECK(!links_[r].in);
    links_[r] = {back_, kNone, true};
    (back_ == kNone ? front_ : links_[back_].after) = r;
    back_ = r;
  }

  void erase(RecordNumber r) {
    ATRIUM_CHECK(contains(r));
    const Link link = links_[r];
    (link.before == kNone ? front_ : links_[link.before].after) = link.after;
    (link.after == kNone ? back_ : links_[link.after].before) = link.before;
    links_[r] = {};
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
    if (r >= links_.size()) links_.resize(r + 1);
  }

  std::vector<Link> links_;
  RecordNumber front_ = kNone, back_ = kNone;
};

}  // namespace atrium
