// Belady-size: first goes what is not asked for again, then the largest size × distance to the next
// request: the bytes that keeping it would cost, for as long as it would cost them. Not optimal,
// but close to it where sizes differ. Exact: of the records of one size the one farthest away is
// the greatest, so a victim is sought among one record a size.
#include <map>
#include <set>
#include <utility>

#include "pagestore/policies/policies.h"
#include "pagestore/policies/queue.h"
#include "pagestore/policies/records.h"

namespace atrium {

namespace {

class BeladySize final : public Policy {
 public:
  void on_insert(RecordNumber record, std::uint64_t bytes) override {
    known_[record] = {bytes, kNever};
  }
  void on_hit(RecordNumber record) override {
    leave(record);
    known_[record].next = kNever;
  }
  void on_foreseen(RecordNumber record, std::uint64_t when) override {
    const bool released = holds(record);
    if (released) leave(record);
    known_[record].next = when;
    if (released) on_release(record);
  }
  void on_resize(RecordNumber record, std::uint64_t bytes) override {
    known_[record].bytes = bytes;
  }
  void on_release(RecordNumber record) override {
    const Known& known = known_[record];
    if (known.next == kNever)
      never_.push_back(record);
    else
      by_size_[known.bytes].insert({known.next, record});
  }
  void on_evict(RecordNumber record) override { leave(record); }

  std::optional<RecordNumber> victim(std::uint64_t now) override {
    if (!never_.empty()) return never_.front();
    std::optional<RecordNumber> greatest;
    double most = -1;
    for (const auto& [bytes, records] : by_size_) {
      const auto [next, record] = *records.rbegin();
      const double cost = static_cast<double>(bytes) * static_cast<double>(next - now);
      if (cost > most) {
        most = cost;
        greatest = record;
      }
    }
    return greatest;
  }

 private:
  static constexpr std::uint64_t kNever = ~std::uint64_t{0};
  struct Known {
    std::uint64_t bytes = 0, next = kNever;
  };
  using ByNext = std::set<std::pair<std::uint64_t, RecordNumber>>;

  bool holds(RecordNumber record) {
    if (never_.contains(record)) return true;
    const auto same_size = by_size_.find(known_[record].bytes);
    return same_size != by_size_.end() && same_size->second.contains({known_[record].next, record});
  }

  void leave(RecordNumber record) {
    if (never_.contains(record)) never_.erase(record);
    const auto same_size = by_size_.find(known_[record].bytes);
    if (same_size == by_size_.end()) return;
    same_size->second.erase({known_[record].next, record});
    if (same_size->second.empty()) by_size_.erase(same_size);
  }

  // Not pinned, by whether they are asked for again.
  Queue never_;  // released longest ago first
  std::map<std::uint64_t, ByNext> by_size_;
  PerRecord<Known> known_;
};

}  // namespace

std::unique_ptr<Policy> make_belady_size(std::uint64_t) { return std::make_unique<BeladySize>(); }

}  // namespace atrium
