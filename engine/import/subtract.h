// What is left of a convex polygon where others of its plane lie over it.
#pragma once

#include <span>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

// Convex pieces of `polygon` minus `others` (convex, coplanar within the tolerance, whatever their
// orientation). Corners are those of the polygons given, bit for bit, and crossings of their edges.
// Pieces narrower than the tolerance are left out.
std::vector<Polygon> subtract(PolygonView polygon, std::span<const PolygonView> others,
                              double tolerance);

}  // namespace atrium
