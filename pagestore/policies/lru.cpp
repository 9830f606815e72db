// LRU by release: the record whose last pin went longest ago goes first. While pinned a record's
// stamp is infinite (facts: Mattson's stack holds for this order).
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

class Lru final : public Policy {
 public:
  void on_insert(RecordNumber, std::uint64_t) override {}
  void on_hit(RecordNumber record) override {
    if (order_.contains(record)) order_.erase(record);  // else pinned already
  }
  void on_release(RecordNumber record) override { order_.push_back(record); }
  void on_resize(RecordNumber, std::uint64_t) override {}
  void on_evict(RecordNumber record) override { order_.erase(record); }
  std::optional<RecordNumber> victim(std::uint64_t) override { return order_.front(); }

 private:
  Queue order_;  // released longest ago first
};

}  // namespace

std::unique_ptr<Policy> make_lru(std::uint64_t) { return std::make_unique<Lru>(); }

}  // namespace atrium
