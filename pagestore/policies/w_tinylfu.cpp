// W-TinyLFU: a record comes into a window of a hundredth of the arena; what the window has no place
// for may go on into the main part only if it was requested more often lately than what would have
// to leave that for it, else it leaves itself. The main part is a segmented LRU: hits take a record
// from probation to protection, which has four fifths, and pushes back its oldest. [Einziger,
// Friedman, Manes, "TinyLFU: A Highly Efficient Cache Admission Policy", ACM ToS 2017] Shares are
// in bytes; all three queues are by release.
//
// 1. A record in the arena stands in exactly one of the three queues.
// 2. protected_ stays within its share, but for its newest record.
#include <cstddef>

#include "pagestore/policies/frequency_sketch.h"
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

constexpr double kWindowShare = 0.01;    // of the arena
constexpr double kProtectedShare = 0.8;  // of the rest

class WTinyLfu final : public Policy {
 public:
  explicit WTinyLfu(std::uint64_t capacity)
      : window_share_(static_cast<std::uint64_t>(static_cast<double>(capacity) * kWindowShare)),
        main_share_(capacity - window_share_),
        protected_share_(
            static_cast<std::uint64_t>(static_cast<double>(main_share_) * kProtectedShare)) {}

  void on_miss(RecordNumber record, std::uint64_t bytes) override {
    sketch_.count(record);
    coming_bytes_ = bytes;
  }
  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    coming_bytes_ = 0;
    sketch_.fit(++records_);
    window_.push_back(record, bytes);
  }
  void on_hit(RecordNumber record) override {
    released_.erase(record);
    sketch_.count(record);
    if (probation_.contains(record)) protect(record);
  }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    queue_of(record).resize(record, bytes);
  }
  void on_release(RecordNumber record) override {
    released_.insert(record);
    queue_of(record).move_to_back(record);
    settle_window();
  }
  void on_evict(RecordNumber record) override {
    released_.erase(record);
    sketch_.fit(--records_);
    queue_of(record).erase(record);
    settle_window();
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    const auto of_window = first_released(window_, released_);
    const auto of_main = victim_of_main();
    if (!of_window || !of_main) return of_window ? of_window : of_main;
    const bool window_over = window_.bytes() + coming_bytes_ > window_share_;
    if (!window_over || sketch_.estimate(*of_window) > sketch_.estimate(*of_main)) return of_main;
    return of_window;
  }

 private:
  SizedQueue& queue_of(RecordNumber record) {
    if (window_.contains(record)) return window_;
    return probation_.contains(record) ? probation_ : protected_;
  }

  std::optional<RecordNumber> victim_of_main() const {
    const auto record = first_released(probation_, released_);
    return record ? record : first_released(protected_, released_);
  }

  void protect(RecordNumber record) {
    protected_.push_back(record, probation_.erase(record));
    while (protected_.bytes() > protected_share_ && protected_.front() != record) {
      const RecordNumber oldest = *protected_.front();
      probation_.push_back(oldest, protected_.erase(oldest));
    }
  }

  // What the window has too much goes into the main part while there is room; but its newest stays,
  // however small the window, so that it has to prove itself against the main part's oldest.
  void settle_window() {
    while (window_.bytes() > window_share_ && window_.after(*window_.front())) {
      const RecordNumber oldest = *window_.front();
      const std::uint64_t bytes = window_.size_of(oldest);
      if (probation_.bytes() + protected_.bytes() + bytes > main_share_) return;
      window_.erase(oldest);
      probation_.push_back(oldest, bytes);
    }
  }

  std::uint64_t window_share_, main_share_, protected_share_;
  SizedQueue window_, probation_, protected_;  // front: the next to go
  RecordSet released_;
  FrequencySketch sketch_;
  std::size_t records_ = 0;         // in the arena
  std::uint64_t coming_bytes_ = 0;  // of the record that room is made for
};

}  // namespace

std::unique_ptr<Policy> make_w_tinylfu(std::uint64_t capacity) {
  return std::make_unique<WTinyLfu>(capacity);
}

}  // namespace atrium
