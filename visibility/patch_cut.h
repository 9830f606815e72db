// Patches: what of each side of a surface faces lit space, cut where walls really cut it and
// nowhere else, so that no element reaches into the next room and few, large patches remain.
//
// Invariants:
//  1. The pieces of a side are convex, do not overlap, and are what of it faces lit cells, but for
//     slivers: nothing of a patch lies in the dark, where no blocker would be known.
//  2. A side that is lit throughout and within one room is one piece with the surface's own
//     vertices, however many cells it borders, unless a wall stands on most of a cut.
// Pure; safe from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "visibility/bsp.h"
#include "visibility/portal.h"

namespace atrium {

struct PatchPiece {
  Polygon polygon;                // counter-clockwise seen from its lit side
  std::vector<CellPiece> pieces;  // what of it each lit cell has
  bool footprint = false;         // see footprint.h
};

// `polygon` is counter-clockwise seen from the side that is asked for.
std::vector<PatchPiece> cut_patch(const Bsp& bsp, const std::vector<bool>& lit, const Rooms& rooms,
                                  PolygonView polygon);

// The part of a piece in front of a plane; without pieces where there is none.
PatchPiece clip(const PatchPiece& piece, const Plane& plane, double tolerance);

}  // namespace atrium
