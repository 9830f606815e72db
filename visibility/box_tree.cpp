#include "visibility/box_tree.h"

#include <algorithm>
#include <numeric>

namespace atrium {

namespace {
constexpr std::uint32_t kLeafItems = 8;
}

BoxTree::BoxTree(std::vector<Box> boxes) : boxes_(std::move(boxes)), items_(boxes_.size()) {
  std::iota(items_.begin(), items_.end(), 0u);
  if (items_.empty()) return;
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(items_.size()));
}

void BoxTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t count) {
  Box box, centers;
  for (std::uint32_t i = first; i < first + count; ++i) {
    box.extend(boxes_[items_[i]]);
    centers.extend(boxes_[items_[i]].center());
  }
  nodes_[node].box = box;
  if (count <= kLeafItems) {
    nodes_[node].first = first;
    nodes_[node].count = count;
    return;
  }
  const Vec3 size = centers.extent();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  const auto begin = items_.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    const double x = boxes_[a].center()[axis], y = boxes_[b].center()[axis];
    return x != y ? x < y : a < b;
  });
  const auto child = static_cast<std::uint32_t>(nodes_.size());
  nodes_[node].first = child;
  nodes_.resize(nodes_.size() + 2);
  build(child, first, half);
  build(child + 1, first + half, count - half);
}

}  // namespace atrium
