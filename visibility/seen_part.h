// Seen part: what of a convex polygon is seen from a point past a list of convex blockers, exactly:
// each blocker's pyramid from the point is cut out of what the ones before it left. What rays
// sample, this measures; it pays where a tube lists few blockers. [Nishita & Nakamae 85]
//
// Invariant: blockers count between the point and the polygon's plane alone; what lies in that
// plane, touches it to within the tolerance, or is seen edge on hides nothing. Pure, any thread.
#pragma once

#include <cstdint>
#include <span>

#include "visibility/blocker.h"
#include "visibility/remainder.h"

namespace atrium {

// Blockers that may stand between, by their positions among all.
struct BlockerList {
  std::span<const std::uint32_t> positions;
  std::span<const BlockerPolygon> blockers;
  double tolerance = 0;  // m
};

// Of a polygon with this unit normal; nothing of it from behind. `overflow` where it falls into
// more pieces, or richer ones, than there is room for.
Remainder seen_part(const Vec3& x, PolygonView target, const Vec3& normal, const BlockerList& list);

}  // namespace atrium
