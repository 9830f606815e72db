// Ear clipping of polygons that are not planar: never flattened, cut into triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

// n − 2 triangles of corner numbers. The first corner that can be cut off is, then the search
// starts anew from the first corner left: a quad falls along its 2nd and 4th corner.
std::vector<std::array<std::uint32_t, 3>> clip_ears(PolygonView polygon);

}  // namespace atrium
