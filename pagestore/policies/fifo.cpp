// FIFO: the record that came in longest ago goes first; what is pinned is passed over and keeps its
// place.
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

class Fifo final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t) override { order_.push_back(record); }
  void on_hit(RecordNumber record) override { released_.erase(record); }
  void on_resize(RecordNumber, std::uint64_t) override {}
  void on_release(RecordNumber record) override { released_.insert(record); }
  void on_evict(RecordNumber record) override {
    order_.erase(record);
    released_.erase(record);
  }
  std::optional<RecordNumber> victim(std::uint64_t) override {
    return first_released(order_, released_);
  }

 private:
  Queue order_;  // in longest first
  RecordSet released_;
};

}  // namespace

std::unique_ptr<Policy> make_fifo(std::uint64_t) { return std::make_unique<Fifo>(); }

}  // namespace atrium
