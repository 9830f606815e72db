// Remainder: what is left of a convex polygon after convex parts of it were cut out, as disjoint
// convex pieces. What closes a shaft and what a point sees past blockers are both asked this way.
//
// Invariants:
//  1. Pieces are convex, lie in the polygon's plane, have its orientation and do not overlap.
//  2. Corners within the tolerance of a cut are on it: slivers thinner than that are dropped.
//  3. Once there is no room for all pieces, `overflow` stays set and the pieces mean nothing.
// Plain data on the stack; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/geometry.h"

namespace atrium {

struct ConvexPiece {
  static constexpr std::size_t kMaxCorners = 16;

  std::array<Vec3, kMaxCorners> at;
  std::size_t corners = 0;

  PolygonView polygon() const { return {at.data(), corners}; }
};

struct Remainder {
  static constexpr std::size_t kMaxPieces = 24;

  std::array<ConvexPiece, kMaxPieces> pieces;
  std::size_t count = 0;
  bool whole = true;  // nothing was cut out yet
  bool overflow = false;

  explicit Remainder(PolygonView polygon);
  bool nothing() const { return count == 0 && !overflow; }

  void clear() { count = 0, whole = false; }
  // Takes out what lies within all the planes, which face inward.
  void cut_out(std::span<const Plane> planes, double tolerance);
};

// The part of the piece in front of the plane; `fits` turns false where that has too many corners.
ConvexPiece in_front(const ConvexPiece& piece, const Plane& plane, bool& fits);

}  // namespace atrium
