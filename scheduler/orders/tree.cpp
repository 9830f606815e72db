// Tree order walks a minimum spanning tree over gather sets, whose distance is the bytes by which
// they differ: depth first, small branches before large ones, so that the walk is soon back where
// it turned off. [THFH94 §6.1 names minimum spanning trees as under way]
#include <algorithm>
#include <numeric>
#include <tuple>

#include "engine/disjoint_sets.h"
#include "scheduler/orders/constructed.h"

namespace atrium {

namespace {

struct Edge {
  float distance;
  std::uint32_t a, b;
  friend bool operator<(const Edge& x, const Edge& y) {
    return std::tie(x.distance, x.a, x.b) < std::tie(y.distance, y.a, y.b);
  }
};

using Tree = std::vector<std::vector<std::uint32_t>>;  // by cluster: who hangs together with it

// Where clusters do not see each other, a tree a group that does. [Kruskal 1956]
Tree minimum_spanning_tree(const GatherSets& gathers) {
  std::vector<Edge> edges;
  for (std::uint32_t c = 0; c < gathers.size(); ++c)
    for (const GatherSets::Neighbor& n : gathers.neighbors[c])
      if (c < n.cluster) edges.push_back({n.distance, c, n.cluster});
  std::sort(edges.begin(), edges.end());
  DisjointSets joined(gathers.size());
  Tree tree(gathers.size());
  for (const Edge& e : edges) {
    if (joined.find(e.a) == joined.find(e.b)) continue;
    joined.join(e.a, e.b);
    tree[e.a].push_back(e.b);
    tree[e.b].push_back(e.a);
  }
  return tree;
}

// Parents before children; leaves of each cluster's row its children alone.
std::vector<std::uint32_t> hang_up(std::uint32_t root, Tree& tree) {
  std::vector<std::uint32_t> downwards{root};
  for (std::size_t i = 0; i < downwards.size(); ++i) {
    const std::uint32_t parent = downwards[i];
    for (const std::uint32_t child : tree[parent]) {
      std::erase(tree[child], parent);
      downwards.push_back(child);
    }
  }
  return downwards;
}

}  // namespace

Sequence by_tree(const GatherSets& gathers) {
  Tree tree = minimum_spanning_tree(gathers);
  std::vector<std::uint32_t> size(gathers.size(), 0);  // of the branch that begins here
  Sequence s;
  std::vector<std::uint32_t> next;
  for (std::uint32_t root = 0; root < gathers.size(); ++root) {
    if (size[root] > 0) continue;
    const std::vector<std::uint32_t> downwards = hang_up(root, tree);
    for (auto c = downwards.rbegin(); c != downwards.rend(); ++c) {
      size[*c] = 1;
      for (const std::uint32_t child : tree[*c]) size[*c] += size[child];
      std::sort(tree[*c].begin(), tree[*c].end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(size[a], a) > std::tie(size[b], b);  // the last is taken first
      });
    }
    next.assign(1, root);
    while (!next.empty()) {
      const std::uint32_t c = next.back();
      next.pop_back();
      s.push_back(ClusterId(c));
      next.insert(next.end(), tree[c].begin(), tree[c].end());
    }
  }
  return s;
}

Sequence tree_order(const OrderTask& task) { return by_tree(find_gather_sets(task.model)); }

}  // namespace atrium
