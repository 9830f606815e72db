// S3-FIFO: three queues, first in first out. A record comes into the small one, a tenth of the
// arena; at its end it goes on to the main one if it was requested twice meanwhile, else it leaves
// and is remembered among the ghosts, and comes into the main one if requested while there. In the
// main queue it goes round once more for every request, up to three. [Yang, Zhang, Qiu, Yue,
// Rashmi, "FIFO Queues are All You Need for Cache Eviction", SOSP 2023] All shares are in bytes; a
// record larger than the small queue is not admitted.
#include <algorithm>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/probation.h"

namespace atrium {

namespace {

constexpr double kSmallShare = 0.10;  // of the arena; the rest is the main queue's
constexpr double kGhostShare = 0.90;
constexpr std::uint8_t kPromoteAt = 2;     // requests while in the small queue
constexpr std::uint8_t kMostRequests = 3;  // that are counted

class S3Fifo final : public Probation {
 public:
  explicit S3Fifo(std::uint64_t capacity)
      : Probation(capacity, kSmallShare, kGhostShare), main_share_(capacity - first_share_) {}

  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    requests_[record] = 0;
    Probation::on_insert(record, bytes);
  }
  void on_hit(RecordNumber record) override {
    Probation::on_hit(record);
    std::uint8_t& requests = requests_[record];
    requests = std::min<std::uint8_t>(requests + 1, kMostRequests);
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    if (main_.bytes() <= main_share_)
      if (const auto record = victim_of_small()) return record;
    if (const auto record = victim_of_main()) return record;
    return victim_of_small();
  }

 private:
  std::optional<RecordNumber> victim_of_small() {
    while (const auto record = first_released(first_, released_)) {
      if (requests_[*record] < kPromoteAt) return record;
      requests_[*record] = 0;
      main_.push_back(*record, first_.erase(*record));
    }
    return std::nullopt;
  }

  std::optional<RecordNumber> victim_of_main() {
    while (const auto record = first_released(main_, released_)) {
      if (requests_[*record] == 0) return record;
      --requests_[*record];
      main_.move_to_back(*record);
    }
    return std::nullopt;
  }

  const std::uint64_t main_share_;  // bytes
  PerRecord<std::uint8_t> requests_;
};

}  // namespace

std::unique_ptr<Policy> make_s3_fifo(std::uint64_t capacity) {
  return std::make_unique<S3Fifo>(capacity);
}

}  // namespace atrium
