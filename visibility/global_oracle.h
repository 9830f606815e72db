// The global visibility oracle: which clusters may see which. [THFH94 §4, §5]
//
// Invariants:
//  1. Conservative: two clusters of which any two points on lit sides see each other are a pair.
//  2. Rows are symmetric and sorted; a cluster is in its own row where two of its patches face.
// Deterministic for any number of threads.
#pragma once

#include <vector>

#include "engine/model.h"
#include "visibility/bsp.h"
#include "visibility/portal.h"

namespace atrium {

// What of a cluster one cell has: a box along the subdivision's frame.
struct ClusterInCell {
  std::uint32_t cluster = 0, cell = 0;
  Box box;  // in coordinates of Bsp::frame
};

Rows<ClusterId> find_visible(const Bsp& bsp, const std::vector<CellPortal>& portals,
                             const Model& model, const std::vector<ClusterInCell>& places);

}  // namespace atrium
