// 2Q, full version: a record comes into A1in, first in first out, and is forgotten by way of A1out,
// which remembers names only; requested while there, it comes into Am, least recently released
// first out. Hits in A1in change nothing. [Johnson, Shasha, "2Q: A Low Overhead High Performance
// Buffer Management Replacement Algorithm", VLDB 1994, with its Kin = 1/4 and Kout = 1/2] All
// shares are in bytes. Am has no bound of its own, as in the paper; libCacheSim's gives a record up
// when it alone passes three quarters, which shows only where records are large for the arena.
#include "pagestore/policies/policies.h"
#include "pagestore/policies/probation.h"

namespace atrium {

namespace {

constexpr double kInShare = 0.25;  // of the arena
constexpr double kOutShare = 0.5;

// A1in is the first queue, Am the main one, A1out the ghosts.
class TwoQ final : public Probation {
 public:
  explicit TwoQ(std::uint64_t capacity) : Probation(capacity, kInShare, kOutShare) {}

  void on_release(RecordNumber record) override {
    Probation::on_release(record);
    if (main_.contains(record)) main_.move_to_back(record);
  }
  std::optional<RecordNumber> victim(std::uint64_t) override {
    const bool in_first = first_.bytes() > first_share_;
    const auto record = first_released(in_first ? first_ : main_, released_);
    return record ? record : first_released(in_first ? main_ : first_, released_);
  }
};

}  // namespace

std::unique_ptr<Policy> make_two_q(std::uint64_t capacity) {
  return std::make_unique<TwoQ>(capacity);
}

}  // namespace atrium
