// A tree of boxes over a scene's surfaces: which surfaces come near a box.
// Built once, then read from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

class BoxTree {
 public:
  explicit BoxTree(std::vector<Box> boxes);

  // Calls visit(index) for each box that overlaps `query`, in the tree's order.
  template <class Visit>
  void visit(const Box& query, Visit&& visit_box) const {
    if (nodes_.empty()) return;
    std::uint32_t stack[64];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      if (!node.box.overlaps(query)) continue;
      if (node.count == 0) {
        stack[top++] = node.first + 1;
        stack[top++] = node.first;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (boxes_[items_[i]].overlaps(query)) visit_box(items_[i]);
    }
  }

 private:
  struct Node {
    Box box;
    std::uint32_t first = 0;  // of its items, or the first of its two children where count is 0
    std::uint32_t count = 0;
  };
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);

  std::vector<Box> boxes_;
  std::vector<std::uint32_t> items_;
  std::vector<Node> nodes_;
};

}  // namespace atrium
