// LRU by release: the record whose last pin went longest ago goes first. While pinned a record's
// stamp is infinite (facts: Mattson's stack holds for this order).
#include <list>
#include <unordered_map>

#include "engine/check.h"
#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

class Lru final : public Policy {
 public:
  void on_insert(RecordId, std::size_t) override {}
  void on_hit(RecordId id) override { forget(id); }
  void on_release(RecordId id) override {
    const bool fresh = place_.emplace(id, order_.insert(order_.end(), id)).second;
    ATRIUM_CHECK(fresh);
  }
  void on_resize(RecordId, std::size_t) override {}
  void on_evict(RecordId id) override { forget(id); }
  std::optional<RecordId> victim() override {
    if (order_.empty()) return std::nullopt;
    return order_.front();
  }

 private:
  void forget(RecordId id) {
    const auto found = place_.find(id);
    if (found == place_.end()) return;  // pinned already
    order_.erase(found->second);
    place_.erase(found);
  }

  std::list<RecordId> order_;  // released longest ago first
  std::unordered_map<RecordId, std::list<RecordId>::iterator> place_;
};

}  // namespace

std::unique_ptr<Policy> make_lru(std::size_t) { return std::make_unique<Lru>(); }

}  // namespace atrium
