#include "visibility/blocker.h"

#include <algorithm>
#include <array>

#include "engine/check.h"
#include "visibility/shaft.h"

namespace atrium {

namespace {

constexpr std::uint32_t kLeafItems = 4;
constexpr std::size_t kStack = 64;  // median splits: as deep as the count has bits

}  // namespace

bool any_may_stand_between(std::span<const BlockerPolygon> polygons, double tolerance) {
  return std::any_of(polygons.begin(), polygons.end(), [&](const BlockerPolygon& b) {
    const Plane plane = plane_of(b.polygon);
    bool front = false, back = false;
    for (const BlockerPolygon& other : polygons)
      for (const Vec3& x : other.polygon) {
        front |= plane.distance(x) > tolerance;
        back |= plane.distance(x) < -tolerance;
      }
    return front && back;
  });
}

BlockerIndex::BlockerIndex(std::span<const BlockerPolygon> blockers) : blockers_(blockers) {
  items_.reserve(blockers.size());
  for (std::size_t i = 0; i < blockers.size(); ++i)
    items_.push_back({bounds(blockers[i].polygon), static_cast<std::uint32_t>(i)});
  if (!items_.empty()) build(0, static_cast<std::uint32_t>(items_.size()));
}

void BlockerIndex::build(std::uint32_t first, std::uint32_t count) {
  const std::size_t self = nodes_.size();
  Box box, centers;
  for (std::uint32_t i = first; i < first + count; ++i) {
    box.extend(items_[i].box);
    centers.extend(items_[i].box.center());
  }
  nodes_.push_back({box, first, count});
  if (count <= kLeafItems) return;

  const Vec3 e = centers.extent();
  const int axis = e.x >= e.y && e.x >= e.z ? 0 : e.y >= e.z ? 1 : 2;
  const std::uint32_t half = count / 2;
  const auto begin = items_.begin() + first;
  // The position decides between equals, so that the same span gives the same index.
  std::nth_element(begin, begin + half, begin + count, [axis](const Item& a, const Item& b) {
    const double x = a.box.lo[axis] + a.box.hi[axis], y = b.box.lo[axis] + b.box.hi[axis];
    return x != y ? x < y : a.position < b.position;
  });
  build(first, half);
  nodes_[self].first = static_cast<std::uint32_t>(nodes_.size());
  nodes_[self].count = 0;
  build(first + half, count - half);
}

std::optional<std::size_t> BlockerIndex::collect(const Shaft& shaft,
                                                 std::span<std::uint32_t> out) const {
  if (nodes_.empty() || shaft.closed) return 0;
  struct Visit {
    std::uint32_t node;
    std::uint32_t planes;  // those that may still cut the node's box
  };
  std::array<Visit, kStack> stack;
  std::size_t depth = 0, found = 0;
  stack[depth++] = {0, shaft.all_planes()};
  while (depth > 0) {
    Visit visit = stack[--depth];
    const Node& node = nodes_[visit.node];
    if (!may_block(shaft, node.box, visit.planes)) continue;
    if (node.count == 0) {
      ATRIUM_CHECK(depth + 2 <= kStack);
      stack[depth++] = {node.first, visit.planes};
      stack[depth++] = {visit.node + 1, visit.planes};
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      std::uint32_t planes = visit.planes;
      if (!may_block(shaft, items_[i].box, planes)) continue;
      if (!may_block(shaft, blockers_[items_[i].position].polygon, planes)) continue;
      if (found == out.size()) return std::nullopt;
      out[found++] = items_[i].position;
    }
  }
  return found;
}

std::size_t BlockerIndex::bytes() const {
  return items_.capacity() * sizeof(Item) + nodes_.capacity() * sizeof(Node);
}

}  // namespace atrium
