// Footprints: a patch is cut along the outline of what stands on it, a crate on a floor or a
// bookcase against a wall, so that none of its elements is partly inside. Light jumps there, and
// what is inside is nearly always dark: leaves across the outline let a little of the room's light
// in, which white faces throw about in there until it is as bright as the room (boxes of ρ = .98:
// two thirds as bright where no light comes at all). Inside is a patch of its own, whatever comes
// there: a box may have a hole, or a lamp in it.
//
// Only large patches are cut, floors and walls, and only at footprints worth it, the largest first:
// each makes up to four patches of one, and one more. With shelves cut under their books a ward
// took a half more links for the same error. Pure; safe from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene.h"
#include "visibility/box_tree.h"
#include "visibility/patch_cut.h"

namespace atrium {

// Of the median of all area (bsp.h), what a piece's must be; of the piece's, what a footprint's
// must be; and the most that are cut out of one piece.
inline constexpr double kCutOfMedian = 1.0 / 4;
inline constexpr double kFootprintWorthACut = 1.0 / 200;
inline constexpr std::size_t kMostFootprints = 12;

// A piece of surface `own` in convex pieces that do not overlap and together are what it was; those
// within outlines are marked.
// surfaces: the tree of all surfaces' boxes. median: m², of all area.
std::vector<PatchPiece> cut_at_footprints(const Scene& scene, const BoxTree& surfaces,
                                          double median, std::uint32_t own, PatchPiece piece);

}  // namespace atrium
