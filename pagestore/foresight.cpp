#include "pagestore/foresight.h"

namespace atrium {

void Foresight::append(RecordNumber record) {
  if (record >= first_.size()) {
    first_.resize(record + 1, kNeverAgain);
    last_.resize(record + 1, kNeverAgain);
  }
  const std::uint64_t number = end();
  upcoming_.push_back({record, kNeverAgain});
  if (first_[record] == kNeverAgain)
    first_[record] = number;
  else
    upcoming_[last_[record] - now_].again = number;
  last_[record] = number;
}

void Foresight::advance(RecordNumber requested) {
  if (upcoming_.empty()) {
    ++now_;
    return;
  }
  if (upcoming_.front().record != requested) return;
  first_[requested] = upcoming_.front().again;
  upcoming_.pop_front();
  ++now_;
}

void Foresight::forget() {
  for (const Upcoming& u : upcoming_) first_[u.record] = kNeverAgain;
  upcoming_.clear();
}

}  // namespace atrium
