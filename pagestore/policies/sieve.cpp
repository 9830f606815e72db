// SIEVE: first in, first out, but the hand that looks for a victim leaves a record requested since
// it last passed where it is, clears its bit and goes on towards the newer ones; it stays where it
// took the last victim. [Zhang, Yang, Yue, Vigfusson, Rashmi, "SIEVE is Simpler than LRU", NSDI
// 2024] Pinned records are passed over with their bit as it is.
#include "pagestore/policies/arrival_row.h"
#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

class Sieve final : public MarkedArrivalRow {
 public:
  void on_evict(RecordNumber record) override {
    if (hand_ == record) hand_ = order_.after(record);
    MarkedArrivalRow::on_evict(record);
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    if (released_.empty()) return std::nullopt;
    if (!hand_) hand_ = order_.front();
    while (!released_.contains(*hand_) || requested_.contains(*hand_)) {
      if (released_.contains(*hand_)) requested_.erase(*hand_);
      hand_ = order_.after(*hand_);
      if (!hand_) hand_ = order_.front();
    }
    return hand_;
  }

 private:
  std::optional<RecordNumber> hand_;  // where to look next; none: at the front
};

}  // namespace

std::unique_ptr<Policy> make_sieve(std::uint64_t) { return std::make_unique<Sieve>(); }

}  // namespace atrium
