// LFU: the record requested least often since it came in goes first; among those the one released
// longest ago. What leaves the arena is forgotten.
#include <utility>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/ranking.h"

namespace atrium {

namespace {

class Lfu final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t) override { requests_[record] = 1; }
  void on_hit(RecordNumber record) override {
    ++requests_[record];
    if (released_.contains(record)) released_.erase(record);  // else pinned already
  }
  void on_resize(RecordNumber, std::uint64_t) override {}
  void on_release(RecordNumber record) override {
    released_.insert(record, {requests_[record], ++releases_});
  }
  void on_evict(RecordNumber record) override { released_.erase(record); }
  std::optional<RecordNumber> victim(std::uint64_t) override { return released_.first(); }

 private:
  using Key = std::pair<std::uint64_t, std::uint64_t>;  // requests, number of the release
  Ranking<Key> released_;
  PerRecord<std::uint64_t> requests_;
  std::uint64_t releases_ = 0;
};

}  // namespace

std::unique_ptr<Policy> make_lfu(std::uint64_t) { return std::make_unique<Lfu>(); }

}  // namespace atrium
