// Disjoint sets: a forest of parents with paths halved. [Tarjan 75] Each set is named by one of its
// members. For one thread.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace atrium {

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t members) : parent_(members) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }

  std::size_t find(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t i, std::size_t j) { parent_[find(j)] = find(i); }

 private:
  std::vector<std::size_t> parent_;
};

}  // namespace atrium
