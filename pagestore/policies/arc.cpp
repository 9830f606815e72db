// ARC: T1 holds what was requested once lately, T2 what was requested more often, each least
// recently released first out; B1 and B2 remember what they lost. A miss found in B1 says that T1's
// share p of the arena is too small, one found in B2 that it is too large. [Megiddo, Modha, "ARC: A
// Self-Tuning, Low Overhead Replacement Cache", FAST 2003]
//
// All in bytes, where the paper has pages. `arc` moves p by the size of the record found, times the
// paper's ratio of ghosts; `arc-compat`, as libCacheSim does, by that many single bytes. Case IV
// forgets one ghost a victim.
#include <algorithm>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

enum class Step { kRecordSize, kOne };

double ratio(std::uint64_t a, std::uint64_t b) {
  return static_cast<double>(a) / static_cast<double>(b);
}

class Arc final : public Policy {
 public:
  Arc(std::uint64_t capacity, Step step) : capacity_(capacity), step_(step) {}

  void on_miss(RecordNumber record, std::uint64_t bytes) override {
    coming_ = {record, bytes, Found::kNowhere};
    if (b1_.contains(record))
      found_in_b1();
    else if (b2_.contains(record))
      found_in_b2();
  }

  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    const bool again = coming_ && coming_->record == record && coming_->found != Found::kNowhere;
    (again ? t2_ : t1_).push_back(record, bytes);
    coming_.reset();
  }

  void on_hit(RecordNumber record) override {
    released_.erase(record);
    if (t1_.contains(record)) t2_.push_back(record, t1_.erase(record));
  }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    (t1_.contains(record) ? t1_ : t2_).resize(record, bytes);
  }
  void on_release(RecordNumber record) override {
    released_.insert(record);
    (t1_.contains(record) ? t1_ : t2_).move_to_back(record);
  }

  void on_evict(RecordNumber record) override {
    released_.erase(record);
    if (t2_.contains(record)) {
      b2_.push_back(record, t2_.erase(record));
      return;
    }
    const std::uint64_t bytes = t1_.erase(record);
    if (!forgets_victim_) b1_.push_back(record, bytes);
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    forgets_victim_ = false;
    if (!coming_ || coming_->found != Found::kNowhere) return replaced();
    if (t1_.bytes() + b1_.bytes() + coming_->bytes > capacity_) return replaced_of_full_l1();
    const std::uint64_t all = t1_.bytes() + b1_.bytes() + t2_.bytes() + b2_.bytes();
    if (all >= 2 * capacity_ && !b2_.empty()) b2_.erase(*b2_.front());
    return replaced();
  }

 private:
  enum class Found { kNowhere, kB1, kB2 };
  struct Coming {
    RecordNumber record;
    std::uint64_t bytes;
    Found found;
  };

  double step(double ghosts_ratio) const {
    const double unit = step_ == Step::kOne ? 1.0 : static_cast<double>(coming_->bytes);
    return std::max(ghosts_ratio, 1.0) * unit;
  }
  void found_in_b1() {
    share_ =
        std::min(share_ + step(ratio(b2_.bytes(), b1_.bytes())), static_cast<double>(capacity_));
    b1_.erase(coming_->record);
    coming_->found = Found::kB1;
  }
  void found_in_b2() {
    share_ = std::max(share_ - step(ratio(b1_.bytes(), b2_.bytes())), 0.0);
    b2_.erase(coming_->record);
    coming_->found = Found::kB2;
  }

  // Case IV(A): T1 and B1 have the whole arena's bytes between them.
  std::optional<RecordNumber> replaced_of_full_l1() {
    if (!b1_.empty()) {
      b1_.erase(*b1_.front());
      return replaced();
    }
    const auto record = first_released(t1_, released_);
    forgets_victim_ = record.has_value();
    return record ? record : first_released(t2_, released_);
  }

  // REPLACE of the paper; where all of a list is pinned the other one gives.
  std::optional<RecordNumber> replaced() {
    const double t1_bytes = static_cast<double>(t1_.bytes());
    const bool from_b2 = coming_ && coming_->found == Found::kB2;
    const bool t1_over = !t1_.empty() && (t1_bytes > share_ || (t1_bytes == share_ && from_b2));
    const bool t1_first = t1_over || t2_.empty();
    const auto record = first_released(t1_first ? t1_ : t2_, released_);
    return record ? record : first_released(t1_first ? t2_ : t1_, released_);
  }

  std::uint64_t capacity_;
  Step step_;
  SizedQueue t1_, t2_, b1_, b2_;  // front: the next to go
  RecordSet released_;
  double share_ = 0;              // p: the bytes that T1 should have
  std::optional<Coming> coming_;  // missed, and not in the arena yet
  bool forgets_victim_ = false;   // the victim just named leaves no ghost
};

}  // namespace

std::unique_ptr<Policy> make_arc(std::uint64_t capacity) {
  return std::make_unique<Arc>(capacity, Step::kRecordSize);
}

std::unique_ptr<Policy> make_arc_compat(std::uint64_t capacity) {
  return std::make_unique<Arc>(capacity, Step::kOne);
}

}  // namespace atrium
