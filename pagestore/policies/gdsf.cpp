// GDSF: the record of least priority goes first, L + requests × cost / size with cost 1, where L,
// the arena's age, is the priority of the last that went: what has long not been asked for falls
// back behind what comes in. [Cherkasova, "Improving WWW Proxies Performance with
// Greedy-Dual-Size-Frequency Caching Policy", HP Laboratories 1998] Among equals the one released
// longest ago.
#include <algorithm>
#include <utility>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/ranking.h"

namespace atrium {

namespace {

constexpr double kBytesPerUnit = 1e6;  // sizes are in MB, as libCacheSim has them: it rounds alike

class Gdsf final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t bytes) override { known_[record] = {bytes, 1}; }
  void on_hit(RecordNumber record) override {
    ++known_[record].requests;
    if (released_.contains(record)) released_.erase(record);  // else pinned already
  }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    known_[record].bytes = bytes;
  }
  void on_release(RecordNumber record) override {
    Known& known = known_[record];
    const double bytes = static_cast<double>(std::max<std::uint64_t>(known.bytes, 1));
    known.priority = age_ + static_cast<double>(known.requests) * kBytesPerUnit / bytes;
    released_.insert(record, {known.priority, ++releases_});
  }
  void on_evict(RecordNumber record) override {
    age_ = known_[record].priority;
    released_.erase(record);
  }
  std::optional<RecordNumber> victim(std::uint64_t) override { return released_.first(); }

 private:
  struct Known {
    std::uint64_t bytes = 0, requests = 0;
    double priority = 0;  // at its last release
  };
  using Key = std::pair<double, std::uint64_t>;  // priority, number of the release
  Ranking<Key> released_;
  PerRecord<Known> known_;
  double age_ = 0;  // L
  std::uint64_t releases_ = 0;
};

}  // namespace

std::unique_ptr<Policy> make_gdsf(std::uint64_t) { return std::make_unique<Gdsf>(); }

}  // namespace atrium
