// S3-FIFO: three queues, first in first out. A record comes into the small one, a tenth of the
// arena; at its end it goes on to the main one if it was requested twice meanwhile, else it leaves
// and is remembered among the ghosts, and comes into the main one if requested while there. In the
// main queue it goes round once more for every request, up to three. [Yang, Zhang, Qiu, Yue,
// Rashmi, "FIFO Queues are All You Need for Cache Eviction", SOSP 2023] All shares are in bytes; a
// record larger than the small queue is not admitted.
#include <algorithm>

#include "pagestore/policies/ghosts.h"
#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"

namespace atrium {

namespace {

constexpr double kSmallShare = 0.10;  // of the arena; the rest is the main queue's
constexpr double kGhostShare = 0.90;
constexpr std::uint8_t kPromoteAt = 2;     // requests while in the small queue
constexpr std::uint8_t kMostRequests = 3;  // that are counted

class S3Fifo final : public Policy {
 public:
  explicit S3Fifo(std::uint64_t capacity)
      : small_share_(static_cast<std::uint64_t>(static_cast<double>(capacity) * kSmallShare)),
        main_share_(capacity - small_share_),
        ghosts_(static_cast<std::uint64_t>(static_cast<double>(capacity) * kGhostShare)) {}

  void on_miss(RecordNumber record, std::uint64_t) override {
    known_again_ = ghosts_.forget(record) ? std::optional(record) : std::nullopt;
  }
  bool admits(RecordNumber, std::uint64_t bytes) override { return bytes <= small_share_; }

  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    requests_[record] = 0;
    if (known_again_ == record)
      main_.push_back(record, bytes);
    else if (bytes <= small_share_)
      small_.push_back(record, bytes);
    else
      small_.push_front(record, bytes);  // not admitted: the first to go
    known_again_.reset();
  }

  void on_hit(RecordNumber record) override {
    released_.erase(record);
    std::uint8_t& requests = requests_[record];
    requests = std::min<std::uint8_t>(requests + 1, kMostRequests);
  }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    (main_.contains(record) ? main_ : small_).resize(record, bytes);
  }
  void on_release(RecordNumber record) override { released_.insert(record); }

  void on_evict(RecordNumber record) override {
    released_.erase(record);
    if (main_.contains(record))
      main_.erase(record);
    else
      ghosts_.remember(record, small_.erase(record));
  }

  std::optional<RecordNumber> victim(std::uint64_t) override {
    if (main_.bytes() <= main_share_)
      if (const auto record = victim_of_small()) return record;
    if (const auto record = victim_of_main()) return record;
    return victim_of_small();
  }

 private:
  std::optional<RecordNumber> victim_of_small() {
    while (const auto record = first_released(small_, released_)) {
      if (requests_[*record] < kPromoteAt) return record;
      requests_[*record] = 0;
      main_.push_back(*record, small_.erase(*record));
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

  std::uint64_t small_share_, main_share_;
  SizedQueue small_, main_;
  Ghosts ghosts_;
  PerRecord<std::uint8_t> requests_;
  RecordSet released_;
  std::optional<RecordNumber> known_again_;  // missed, and found among the ghosts
};

}  // namespace

std::unique_ptr<Policy> make_s3_fifo(std::uint64_t capacity) {
  return std::make_unique<S3Fifo>(capacity);
}

}  // namespace atrium
