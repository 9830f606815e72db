// A tree of boxes to find pairs that touch. Built once; queries are const and thread safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

class BoxTree {
 public:
  explicit BoxTree(const std::vector<Box>& boxes);

  // Calls visit(i) for every box that overlaps `box` inflated by `margin`.
  template <class Visit>
  void visit(const Box& box, double margin, Visit visit) const {
    if (!nodes_.empty()) descend(0, box, margin, visit);
  }

 private:
  static constexpr std::uint32_t kLeafSize = 8;
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // of a leaf, into order_
    std::uint32_t right = 0;             // the left child follows its parent
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t last);

  template <class Visit>
  void descend(std::uint32_t index, const Box& box, double margin, Visit& visit) const {
    const Node& n = nodes_[index];
    if (!n.box.overlaps(box, margin)) return;
    if (n.right != 0) {
      descend(index + 1, box, margin, visit);
      descend(n.right, box, margin, visit);
      return;
    }
    for (std::uint32_t i = n.first; i < n.first + n.count; ++i)
      if (boxes_[order_[i]].overlaps(box, margin)) visit(order_[i]);
  }

  const std::vector<Box>& boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace atrium
