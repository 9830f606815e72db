// Nearest order gathers next to that cluster, of those that the last one may see, whose gather set
// differs from the last one's by the fewest bytes. Where all of them are done it goes on from the
// most recent gather that still sees one that is not. [THFH94 §6.1 names nearest neighbors as
// under way]
#include <limits>

#include "scheduler/orders/constructed.h"

namespace atrium {

namespace {

constexpr std::uint32_t kNobody = std::numeric_limits<std::uint32_t>::max();

std::uint32_t nearest_left(const GatherSets& gathers, std::uint32_t to,
                           const std::vector<char>& done) {
  std::uint32_t best = kNobody;
  float least = std::numeric_limits<float>::infinity();
  for (const GatherSets::Neighbor& n : gathers.neighbors[to]) {
    if (done[n.cluster] || n.distance >= least) continue;
    best = n.cluster;
    least = n.distance;
  }
  return best;
}

}  // namespace

Sequence by_nearest(const GatherSets& gathers) {
  std::vector<char> done(gathers.size(), 0);
  Sequence s;
  std::vector<std::uint32_t> path;  // gathers that may still see one that is left
  for (std::uint32_t start = 0; start < gathers.size(); ++start) {
    std::uint32_t next = done[start] ? kNobody : start;
    while (next != kNobody) {
      done[next] = 1;
      s.push_back(ClusterId(next));
      path.push_back(next);
      next = kNobody;
      while (next == kNobody && !path.empty()) {
        next = nearest_left(gathers, path.back(), done);
        if (next == kNobody) path.pop_back();
      }
    }
  }
  return s;
}

Sequence nearest_order(const OrderTask& task) { return by_nearest(find_gather_sets(task.model)); }

}  // namespace atrium
