#include "engine/import/box_tree.h"

#include <numeric>

namespace atrium {

BoxTree::BoxTree(const std::vector<Box>& boxes) : boxes_(boxes), order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!boxes.empty()) build(0, static_cast<std::uint32_t>(boxes.size()));
}

std::uint32_t BoxTree::build(std::uint32_t first, std::uint32_t last) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Box box, centers;
  for (std::uint32_t i = first; i < last; ++i) {
    box.extend(boxes_[order_[i]]);
    centers.extend(boxes_[order_[i]].center());
  }
  nodes_[index].box = box;
  if (last - first <= kLeafSize) {
    nodes_[index].first = first;
    nodes_[index].count = last - first;
    return index;
  }
  const Vec3 extent = centers.extent();
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(boxes_[a].center()[axis], a) <
                            std::pair(boxes_[b].center()[axis], b);
                   });
  build(first, middle);
  const std::uint32_t right = build(middle, last);
  nodes_[index].right = right;
  return index;
}

}  // namespace atrium
