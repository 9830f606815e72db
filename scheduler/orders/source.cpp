// "Source order gathers to that cluster which has most often acted as a source (ties are broken by
// proximity to the most recent gatherer)." [THFH94 §6] Of two as near, the first in the model.
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <span>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

// Clusters that are still to be gathered to, as leaves of a tree that halves their centres along
// the longest extent; each node knows how often that of its leaves has acted which has most. So one
// more source is one walk to the root, and both questions are asked of one tree.
class StillToCome {
 public:
  explicit StillToCome(const Model& model) : leaf_of_(model.clusters.size()) {
    for (const Cluster& c : model.clusters) centers_.push_back(c.bounds.center());
    std::vector<std::uint32_t> all(centers_.size());
    std::iota(all.begin(), all.end(), 0u);
    if (!all.empty()) add(all, kNone);
  }

  void count_source(std::uint32_t cluster) {
    if (nodes_[leaf_of_[cluster]].most != kGone)
      set(leaf_of_[cluster], nodes_[leaf_of_[cluster]].most + 1);
  }
  void take_out(std::uint32_t cluster) { set(leaf_of_[cluster], kGone); }

  // Of those that have acted most often.
  std::uint32_t nearest_to(std::uint32_t cluster) const {
    Nearest found;
    look(0, centers_[cluster], found);
    return found.cluster;
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::int64_t kGone = -1;
  struct Node {
    Box box;  // of its centres
    std::int64_t most = 0;
    std::uint32_t parent = kNone;
    std::array<std::uint32_t, 2> child{kNone, kNone};
    std::uint32_t cluster = kNone;  // of a leaf
  };
  struct Nearest {
    double distance2 = std::numeric_limits<double>::infinity();
    std::uint32_t cluster = kNone;
  };

  std::uint32_t add(std::span<std::uint32_t> clusters, std::uint32_t parent) {
    const auto at = std::uint32_t(nodes_.size());
    Node node;
    node.parent = parent;
    for (const std::uint32_t c : clusters) node.box.extend(centers_[c]);
    if (clusters.size() == 1) leaf_of_[node.cluster = clusters[0]] = at;
    nodes_.push_back(node);
    if (clusters.size() == 1) return at;
    const Vec3 extent = node.box.extent();
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (extent[k] > extent[axis]) axis = k;
    const std::size_t half = clusters.size() / 2;
    std::ranges::nth_element(clusters, clusters.begin() + std::ptrdiff_t(half), {},
                             [&](std::uint32_t c) { return centers_[c][axis]; });
    const std::uint32_t first = add(clusters.first(half), at);
    const std::uint32_t second = add(clusters.subspan(half), at);
    nodes_[at].child = {first, second};
    return at;
  }

  void set(std::uint32_t leaf, std::int64_t most) {
    nodes_[leaf].most = most;
    for (std::uint32_t n = nodes_[leaf].parent; n != kNone; n = nodes_[n].parent) {
      const auto [a, b] = nodes_[n].child;
      const std::int64_t now = std::max(nodes_[a].most, nodes_[b].most);
      if (now == nodes_[n].most) return;
      nodes_[n].most = now;
    }
  }

  // No more than to any centre in it, rounding included: each step of that is monotone.
  double distance2(std::uint32_t node, const Vec3& x) const {
    const Box& box = nodes_[node].box;
    Vec3 d;
    for (int k = 0; k < 3; ++k) d[k] = x[k] - std::clamp(x[k], box.lo[k], box.hi[k]);
    return dot(d, d);
  }

  void look(std::uint32_t n, const Vec3& x, Nearest& found) const {
    const Node& node = nodes_[n];
    const double away = distance2(n, x);
    if (node.most < nodes_[0].most || away > found.distance2) return;
    if (node.cluster != kNone) {
      if (away < found.distance2 || node.cluster < found.cluster) found = {away, node.cluster};
      return;
    }
    const auto [a, b] = node.child;
    const bool in_order = distance2(a, x) <= distance2(b, x);
    look(in_order ? a : b, x, found);
    look(in_order ? b : a, x, found);
  }

  std::vector<Vec3> centers_;
  std::vector<Node> nodes_;  // the root first
  std::vector<std::uint32_t> leaf_of_;
};

}  // namespace

Sequence source_order(const OrderTask& task) {
  const Model& model = task.model;
  StillToCome still_to_come(model);
  Sequence s;
  for (std::uint32_t last = 0; s.size() < model.clusters.size();) {
    last = still_to_come.nearest_to(last);
    still_to_come.take_out(last);
    s.push_back(ClusterId(last));
    for (const ClusterId source : model.visible[last]) still_to_come.count_source(source.value);
  }
  return s;
}

}  // namespace atrium
