// Probation: what 2Q and S3-FIFO have in common: a record comes into a first queue of a share of the
// arena; leaving it, it is remembered among the ghosts, and comes into the main queue if requested
// while there. A record larger than the first queue is not admitted. Who leaves is the policy's.
#pragma once

#include <optional>

#include "pagestore/policies/ghosts.h"
#include "pagestore/policies/queue.h"
#include "pagestore/policy.h"

namespace atrium {

class Probation : public Policy {
 public:
  void on_miss(RecordNumber record, std::uint64_t) final {
    known_again_ = ghosts_.forget(record) ? std::optional(record) : std::nullopt;
  }
  bool admits(RecordNumber, std::uint64_t bytes) final { return bytes <= first_share_; }

  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    if (known_again_ == record)
      main_.push_back(record, bytes);
    else if (bytes <= first_share_)
      first_.push_back(record, bytes);
    else
      first_.push_front(record, bytes);  // not admitted: the first to go
    known_again_.reset();
  }
  void on_hit(RecordNumber record) override { released_.erase(record); }
  void on_resize(RecordNumber record, std::uint64_t bytes) final {
    (main_.contains(record) ? main_ : first_).resize(record, bytes);
  }
  void on_release(RecordNumber record) override { released_.insert(record); }

  void on_evict(RecordNumber record) final {
    released_.erase(record);
    if (main_.contains(record))
      main_.erase(record);
    else
      ghosts_.remember(record, first_.erase(record));
  }

 protected:
  // Shares of the arena.
  Probation(std::uint64_t capacity, double first_share, double ghost_share)
      : first_share_(share(capacity, first_share)), ghosts_(share(capacity, ghost_share)) {}

  const std::uint64_t first_share_;  // bytes
  SizedQueue first_, main_;
  RecordSet released_;

 private:
  static std::uint64_t share(std::uint64_t capacity, double of_it) {
    return static_cast<std::uint64_t>(static_cast<double>(capacity) * of_it);
  }

  Ghosts ghosts_;
  std::optional<RecordNumber> known_again_;  // missed, and found among the ghosts
};

}  // namespace atrium
