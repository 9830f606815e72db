// CLOCK with one bit: first in, first out, but a record requested since the hand last passed it
// goes to the back once more, its bit cleared. [Corbató, "A Paging Experiment with the Multics
// System", 1968] A pinned record goes to the back with its bit as it is.
#include "pagestore/policies/arrival_row.h"
#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

class Clock final : public MarkedArrivalRow {
 public:
  // The hand stands at the front of the row.
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
};

}  // namespace

std::unique_ptr<Policy> make_clock(std::uint64_t) { return std::make_unique<Clock>(); }

}  // namespace atrium
