// ArrivalRow: what FIFO, CLOCK and SIEVE have in common: records in the order in which they came in,
// and which of them are released. Who leaves is the policy's.
#pragma once

#include "pagestore/policies/queue.h"
#include "pagestore/policy.h"

namespace atrium {

class ArrivalRow : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t) final { order_.push_back(record); }
  void on_hit(RecordNumber record) override { released_.erase(record); }
  void on_resize(RecordNumber, std::uint64_t) final {}
  void on_release(RecordNumber record) final { released_.insert(record); }
  void on_evict(RecordNumber record) override {
    order_.erase(record);
    released_.erase(record);
  }

 protected:
  Queue order_;  // in longest first
  RecordSet released_;
};

// With a bit for each record: requested since it came in, or since the hand last cleared it.
class MarkedArrivalRow : public ArrivalRow {
 public:
  void on_hit(RecordNumber record) final {
    ArrivalRow::on_hit(record);
    requested_.insert(record);
  }
  void on_evict(RecordNumber record) override {
    ArrivalRow::on_evict(record);
    requested_.erase(record);
  }

 protected:
  RecordSet requested_;
};

}  // namespace atrium
