// CLOCK with one bit: first in, first out, but a record requested since the hand last passed it
// goes to the back once more, its bit cleared. [Corbató, "A Paging Experiment with the Multics
// System", 1968] A pinned record goes to the back with its bit as it is.
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

class Clock final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t) override { order_.push_back(record); }
  void on_hit(RecordNumber record) override {
    released_.erase(record);
    requested_.insert(record);
  }
  void on_resize(RecordNumber, std::uint64_t) override {}
  void on_release(RecordNumber record) override { released_.insert(record); }
  void on_evict(RecordNumber record) override {
    order_.erase(record);
    released_.erase(record);
    requested_.erase(record);
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    if (released_.empty()) return std::nullopt;
    for (;;) {
      const RecordNumber record = *order_.front();
      const bool released = released_.contains(record);
      if (released && !requested_.contains(record)) return record;
      if (released) requested_.erase(record);
      order_.move_to_back(record);
    }
  }

 private:
  Queue order_;  // the hand stands at the front
  RecordSet released_, requested_;
};

}  // namespace

std::unique_ptr<Policy> make_clock(std::uint64_t) { return std::make_unique<Clock>(); }

}  // namespace atrium
