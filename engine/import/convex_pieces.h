// Cutting plane regions into few convex pieces. A region is a set of simple loops, outer ones
// counter-clockwise and holes clockwise; loops may touch but not cross.
//
// Every reflex corner is resolved by one cut: along one of its edges, across the corner, or to
// another corner, whichever is cheapest; short cuts that meet edges squarely are cheap, and those
// that resolve two reflex corners at once. A rectilinear outline falls into rectangles. Cuts may
// end inside an edge: such new points are appended to `points`.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/import/plane_loops.h"
#include "engine/vec.h"

namespace atrium {

inline constexpr std::size_t kMostCorners = 6000;

// The loops' convex pieces without collinear corners, or nothing where the loops are not what they
// should be (crossing, or more than kMostCorners) or where the pieces miss the region's area by
// more than `area_slack`. `tolerance`: dents and deviations below it do not count.
std::optional<std::vector<Ring>> convex_pieces(std::vector<Vec2>& points,
                                               std::span<const Ring> loops, double tolerance,
                                               double area_slack);

}  // namespace atrium
