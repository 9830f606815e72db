#include "scheduler/leaves.h"

namespace atrium {

// Of the first half's edges the cut alone has the second half, and so its centroid, beyond it.
Cut cut_of(const PatchView& patch, std::int32_t i) {
  const std::int32_t child = patch.elements[i].child;
  const std::span<const Vec2> o = patch.polygon(patch.elements[child]);
  const Vec2 second = patch.elements[child + 1].centroid;
  for (std::size_t a = o.size() - 1, b = 0; b < o.size(); a = b++) {
    const Cut cut{o[a], o[b] - o[a], child};
    if (cut.in_second(second)) return cut;
  }
  return {.child = child};  // without width: all is the first half's
}

std::int32_t leaf_at(const PatchView& patch, const Vec2& p, std::int32_t above) {
  std::int32_t i = above;
  while (!patch.elements[i].leaf()) {
    const Cut cut = cut_of(patch, i);
    i = cut.in_second(p) ? cut.child + 1 : cut.child;
  }
  return i;
}

}  // namespace atrium
