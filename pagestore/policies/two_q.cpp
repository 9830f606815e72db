// 2Q, full version: a record comes into A1in, first in first out, and is forgotten by way of A1out,
// which remembers names only; requested while there, it comes into Am, least recently released
// first out. Hits in A1in change nothing. [Johnson, Shasha, "2Q: A Low Overhead High Performance
// Buffer Management Replacement Algorithm", VLDB 1994, with its Kin = 1/4 and Kout = 1/2] All
// shares are in bytes. Am has no bound of its own, as in the paper; libCacheSim's gives a record up
// when it alone passes three quarters, which shows only where records are large for the arena.
#include "pagestore/policies/ghosts.h"
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

constexpr double kInShare = 0.25;  // of the arena
constexpr double kOutShare = 0.5;

class TwoQ final : public Policy {
 public:
  explicit TwoQ(std::uint64_t capacity)
      : in_share_(static_cast<std::uint64_t>(static_cast<double>(capacity) * kInShare)),
        a1out_(static_cast<std::uint64_t>(static_cast<double>(capacity) * kOutShare)) {}

  void on_miss(RecordNumber record, std::uint64_t) override {
    known_again_ = a1out_.forget(record) ? std::optional(record) : std::nullopt;
  }
  bool admits(RecordNumber, std::uint64_t bytes) override { return bytes <= in_share_; }

  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    if (known_again_ == record)
      am_.push_back(record, bytes);
    else if (bytes <= in_share_)
      a1in_.push_back(record, bytes);
    else
      a1in_.push_front(record, bytes);  // not admitted: the first to go
    known_again_.reset();
  }

  void on_hit(RecordNumber record) override { released_.erase(record); }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    (am_.contains(record) ? am_ : a1in_).resize(record, bytes);
  }
  void on_release(RecordNumber record) override {
    released_.insert(record);
    if (am_.contains(record)) am_.move_to_back(record);
  }

  void on_evict(RecordNumber record) override {
    released_.erase(record);
    if (am_.contains(record))
      am_.erase(record);
    else
      a1out_.remember(record, a1in_.erase(record));
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    const bool in_first = a1in_.bytes() > in_share_;
    const auto record = first_released(in_first ? a1in_ : am_, released_);
    return record ? record : first_released(in_first ? am_ : a1in_, released_);
  }

 private:
  std::uint64_t in_share_;
  SizedQueue a1in_, am_;
  Ghosts a1out_;
  RecordSet released_;
  std::optional<RecordNumber> known_again_;  // missed, and found in A1out
};

}  // namespace

std::unique_ptr<Policy> make_two_q(std::uint64_t capacity) {
  return std::make_unique<TwoQ>(capacity);
}

}  // namespace atrium
