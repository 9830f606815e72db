// Foresight: the next requests of a store's caller, in order, as far as it has told them, and when
// each record is wanted next. The schedule of a solve is known before it begins, so that Belady's
// choice and reading ahead need no guess. [Cao, Felten, Karlin, Li, SIGMETRICS 1995]
//
// Requests are numbered from 0. A request that was not told (nothing is known, or another record is
// next) takes no number while others are still expected.
// Not thread safe.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "pagestore/policy.h"
#include "pagestore/trace.h"

namespace atrium {

class Foresight {
 public:
  std::uint64_t now() const { return now_; }  // the number of the next request
  std::uint64_t end() const { return now_ + upcoming_.size(); }  // of the first one not known

  void append(RecordNumber record);
  void advance(RecordNumber requested);
  void forget();  // nothing is known any more

  // now() <= number < end()
  RecordNumber at(std::uint64_t number) const { return upcoming_[number - now_].record; }
  // The first request for the record that is known; kNeverAgain if none is.
  std::uint64_t next_of(RecordNumber record) const {
    return record < first_.size() ? first_[record] : kNeverAgain;
  }

  std::size_t bytes() const {
    return upcoming_.size() * sizeof(Upcoming) + (first_.size() + last_.size()) * sizeof(now_);
  }

 private:
  struct Upcoming {
    RecordNumber record;
    std::uint64_t again;  // number of its next request, if known
  };
  std::uint64_t now_ = 0;
  std::deque<Upcoming> upcoming_;
  std::vector<std::uint64_t> first_, last_;  // by record, of those known
};

}  // namespace atrium
