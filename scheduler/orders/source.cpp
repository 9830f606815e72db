// "Source order gathers to that cluster which has most often acted as a source (ties are broken by
// proximity to the most recent gatherer)." [THFH94 §6]
#include <limits>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

double distance2(const Box& a, const Box& b) {
  const Vec3 d = a.center() - b.center();
  return dot(d, d);
}

}  // namespace

Sequence source_order(const OrderTask& task) {
  const Model& model = task.model;
  const std::size_t n = model.clusters.size();
  std::vector<std::uint32_t> acted(n, 0);
  std::vector<char> done(n, 0);
  Sequence s;
  std::size_t last = 0;
  for (std::size_t step = 0; step < n; ++step) {
    std::size_t best = n;
    double best_distance = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < n; ++c) {
      if (done[c] || (best < n && acted[c] < acted[best])) continue;
      const double d = distance2(model.clusters[c].bounds, model.clusters[last].bounds);
      if (best == n || acted[c] > acted[best] || d < best_distance) {
        best = c;
        best_distance = d;
      }
    }
    done[best] = 1;
    s.push_back(ClusterId(best));
    for (const ClusterId source : model.visible[best]) ++acted[source.value];
    last = best;
  }
  return s;
}

}  // namespace atrium
