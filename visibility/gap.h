// Gaps: openings so narrow that a scene's author did not mean them, closed where that is asked for.
// Walls that miss each other by a millimetre join rooms to the insides of walls, and those to each
// other; without the portals of such openings they are dark again. No tolerance changes: all other
// portals stay as they are. [facts: visibility, traps]
//
// Invariants:
//  1. Nothing wider than asked for is closed: a portal is taken out only where no ball of that size
//     passes it, only as a part of an opening that is as narrow (opening.h), and not where the
//     opening goes on in a cell beside it.
//  2. What this hides is seen through reported gaps alone: sight from lit space comes to a gap that
//     touches lit space before it comes to any other.
// Pure functions; safe from any thread.
#pragma once

#include <vector>

#include "engine/model.h"
#include "engine/scene.h"
#include "visibility/box_tree.h"
#include "visibility/bsp.h"
#include "visibility/opening.h"
#include "visibility/portal.h"

namespace atrium {

struct Gap {
  NarrowOpening opening;
  std::vector<CellPortal> portals;  // that were taken out
};

// Takes the portals of openings up to `size` metres wide out. Nothing is done for a size of 0.
std::vector<Gap> close_gaps(const Bsp& bsp, double size, std::vector<CellPortal>& portals);

// Those that touch lit space, the widest first. `tree` is of the scene's surfaces.
std::vector<ClosedGap> gaps_of_light(const Scene& scene, const BoxTree& tree,
                                     const std::vector<Gap>& gaps, const std::vector<bool>& lit);

}  // namespace atrium
