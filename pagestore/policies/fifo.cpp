// FIFO: the record that came in longest ago goes first; what is pinned is passed over and keeps its
// place.
#include "pagestore/policies/arrival_row.h"
#include "pagestore/policies/policies.h"

namespace atrium {

namespace {

class Fifo final : public ArrivalRow {
 public:
  std::optional<RecordNumber> victim(std::uint64_t) override {
    return first_released(order_, released_);
  }
};

}  // namespace

std::unique_ptr<Policy> make_fifo(std::uint64_t) { return std::make_unique<Fifo>(); }

}  // namespace atrium
