// Tube: the blockers between a pair of entities p and q, and what they leave to be seen. A tube's
// list is drawn from its working set's blockers, narrowed when p or q subdivides: only what is in
// the parent's list can be in the child's. [THFH94 §4; Teller & Hanrahan 93]
//
// Invariants:
//  1. Conservative: a list misses no blocker that reaches into the shaft by more than the
//     tolerance. VISIBLE and INVISIBLE are certain, the latter by one blocker or by several in one
//     plane; PARTIAL is what neither could be shown for.
//  2. A tube with more candidates than kCapacity is crowded: it holds no list, is PARTIAL, and its
//     children draw theirs from the working set's index again.
//  3. Plain data without heap; copying one is copying an array.
// Queries are pure but for Tube::decided, which belongs to whoever owns the tube.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/geometry.h"
#include "visibility/blocker.h"
#include "visibility/shaft.h"

namespace atrium {

enum class Variety : std::uint8_t { INVISIBLE, VISIBLE, PARTIAL };

// Two convex polygons and the unit normals of their lit sides.
struct PolygonPair {
  PolygonView p;
  Vec3 p_normal{0};
  PolygonView q;
  Vec3 q_normal{0};
};

struct Tube {
  static constexpr std::size_t kCapacity = 32;

  std::array<std::uint32_t, kCapacity> blockers;  // positions in BlockerIndex::blockers()
  std::uint8_t count = 0;
  bool crowded = false;
  bool decided = false;  // is `known` the last word? variety() sees to it
  Variety known = Variety::PARTIAL;

  std::span<const std::uint32_t> list() const { return {blockers.data(), count}; }
};

// The tube of two entities by their shaft, which for clusters is that of their boxes.
Tube make_tube(const Shaft& shaft, const BlockerIndex& index);
Tube make_tube(const PolygonPair& ends, const BlockerIndex& index, double tolerance);

// Is the tube wholly seen or wholly hidden? Then so are all tubes within it, and none is drawn.
inline bool inherits(const Tube& parent) {
  return parent.decided && parent.known != Variety::PARTIAL;
}

// The tube within the parent's, or on its own, of a pair that is known to be PARTIAL: it is not drawn,
// and keeps the parent's list.
Tube undrawn(const Tube* parent);

// The tube of two entities within the parent's. VISIBLE and INVISIBLE are inherited; a list is
// narrowed to the child's shaft.
Tube subdivide(const Tube& parent, const Shaft& child, const BlockerIndex& index);
Tube subdivide(const Tube& parent, const PolygonPair& child, const BlockerIndex& index,
               double tolerance);

// What p and q see of each other, worked out the first time it is asked for.
Variety variety(Tube& tube, const PolygonPair& ends, const BlockerIndex& index, double tolerance);

}  // namespace atrium
