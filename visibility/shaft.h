// Shaft: the convex hull of two entities, as the planes that bound it. Whatever does not reach
// into it cannot stand between them. [Haines & Wallace 91; Teller & Hanrahan 93; THFH94 §4]
//
// Invariants:
//  1. The planes' intersection contains the hull: a plane that cannot be had is left out, never
//     guessed. So every answer is conservative.
//  2. `tolerance` is the depth to which a blocker has to reach into the hull: what only touches
//     it (walls along the floor's edge, the two entities themselves, coplanar ones) does not block.
// Plain data; all functions are pure.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/geometry.h"

namespace atrium {

struct Shaft {
  // Two polygons of kMaxCorners, each with two corners more from clipping, and their own planes.
  static constexpr std::size_t kMaxCorners = 13;
  static constexpr std::size_t kMaxPlanes = 32;  // a bit each
  static_assert(2 * (kMaxCorners + 2) + 2 <= kMaxPlanes);

  bool closed = true;  // neither has anything in front of the other: no light goes through
  std::uint8_t plane_count = 0;
  double tolerance = 0;                  // metres
  Box box;                               // of the hull
  std::array<Plane, kMaxPlanes> planes;  // facing inward

  std::span<const Plane> sides() const { return {planes.data(), plane_count}; }
  std::uint32_t all_planes() const {
    return static_cast<std::uint32_t>((std::uint64_t{1} << plane_count) - 1);
  }
};

// The shaft between what lies of p in front of q and of q in front of p. p and q are convex, np
// and nq the unit normals of their lit sides. A polygon of more than kMaxCorners corners is taken
// as its bounding rectangle.
Shaft make_shaft(PolygonView p, const Vec3& np, PolygonView q, const Vec3& nq, double tolerance);

// The shaft between all that is in two boxes; never closed unless one of them is empty.
Shaft make_shaft(const Box& p, const Box& q, double tolerance);

// Does the convex polygon reach deeper than the tolerance into the hull? Never a wrong "no".
bool may_block(const Shaft& shaft, PolygonView blocker);

// The same where only the shaft's `planes` (a bit each) can cut and the boxes overlap.
bool may_block(const Shaft& shaft, PolygonView blocker, std::uint32_t planes);

// May the box hold something that blocks? `planes` are those to look at, and keeps those that cut
// the box: all that is in it need only be held against them.
bool may_block(const Shaft& shaft, const Box& box, std::uint32_t& planes);

// Does every segment from p to q, all convex, pass through the blocker? Gaps narrower than the
// tolerance count as closed.
bool blocks_all(PolygonView p, PolygonView q, PolygonView blocker, double tolerance);

// The same of several blockers in one plane, pieces of a wall that cells or a modeller cut, which
// jointly cover the hull's section there. May miss one that is cut into many.
bool block_all_together(PolygonView p, PolygonView q, std::span<const PolygonView> coplanar,
                        double tolerance);

// Are p and q on either side of the plane, up to the tolerance?
bool separates(const Plane& plane, PolygonView p, PolygonView q, double tolerance);

}  // namespace atrium
