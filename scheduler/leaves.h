// Which leaf of a patch's tree holds a point, or many: from cut to cut. Pure functions.
#pragma once

#include <cstdint>
#include <span>

#include "engine/cluster_record.h"

namespace atrium {

// The line that halves an element: what lies to the right of `along` is the second half's.
struct Cut {
  Vec2 at{0}, along{0};
  std::int32_t child = 0;  // the first half

  bool in_second(const Vec2& p) const {
    return along.x * (p.y - at.y) - along.y * (p.x - at.x) < 0;
  }
};
// i: no leaf.
Cut cut_of(const PatchView& patch, std::int32_t i);

// The leaf of a tree that holds p (patch frame), found from an element above it.
std::int32_t leaf_at(const PatchView& patch, const Vec2& p, std::int32_t above = 0);

// A point of a patch, and which of its owner's it is.
struct Landing {
  Vec2 p{0};
  std::uint32_t number = 0;
};

// Calls visit(leaf, landings) with each leaf that holds any of them. They go down the tree
// together, so that each cut is found once, and are left in the order of the leaves.
template <class Visit>
void each_leaf(const PatchView& patch, std::span<Landing> landings, const Visit& visit,
               std::int32_t above = 0) {
  std::int32_t i = above;
  while (!landings.empty() && !patch.elements[i].leaf()) {
    const Cut cut = cut_of(patch, i);
    // Without branches, which chance would decide.
    std::size_t first = 0;
    for (Landing& at : landings) {
      const Landing landing = at;
      at = landings[first];
      landings[first] = landing;
      first += cut.in_second(landing.p) ? 0 : 1;
    }
    each_leaf(patch, landings.first(first), visit, cut.child);
    landings = landings.subspan(first);
    i = cut.child + 1;
  }
  if (!landings.empty()) visit(i, landings);
}

}  // namespace atrium
