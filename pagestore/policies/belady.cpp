// Belady's MIN, as far as the future is told: first goes, of the records whose next request is not
// known, the one released longest ago; then the one whose next request is farthest. [Belady, "A
// Study of Replacement Algorithms for a Virtual-Storage Computer", 1966]
//
// `belady` is told everything: not known means never again. `lookahead:W` is told what lies within
// W requests, a real policy where the schedule is known: among what is not asked for soon, LRU.
#include <cstdint>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"
#include "pagestore/policies/ranking.h"

namespace atrium {

namespace {

class Belady final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t) override { next_[record] = kNotKnown; }
  void on_hit(RecordNumber record) override {
    leave(record);
    next_[record] = kNotKnown;
  }
  void on_foreseen(RecordNumber record, std::uint64_t when) override {
    const bool held = unknown_.contains(record) || known_.contains(record);  // else pinned
    if (held) leave(record);
    next_[record] = when;
    if (held) known_.insert(record, {when});
  }
  void on_resize(RecordNumber, std::uint64_t) override {}
  void on_release(RecordNumber record) override {
    if (next_[record] == kNotKnown)
      unknown_.push_back(record);
    else
      known_.insert(record, {next_[record]});
  }
  void on_evict(RecordNumber record) override { leave(record); }
  std::optional<RecordNumber> victim(std::uint64_t) override {
    return unknown_.empty() ? known_.first() : unknown_.front();
  }

 private:
  static constexpr std::uint64_t kNotKnown = ~std::uint64_t{0};
  struct FarthestFirst {
    std::uint64_t when;
    bool operator<(const FarthestFirst& other) const { return when > other.when; }
  };

  void leave(RecordNumber record) {
    if (unknown_.contains(record)) unknown_.erase(record);
    if (known_.contains(record)) known_.erase(record);
  }

  // Not pinned, by whether the next request is known.
  Queue unknown_;  // released longest ago first
  Ranking<FarthestFirst> known_;
  PerRecord<std::uint64_t> next_;
};

}  // namespace

std::unique_ptr<Policy> make_belady(std::uint64_t) { return std::make_unique<Belady>(); }

}  // namespace atrium
