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
#include "visibility/cell_visibility.h"
#include "visibility/portal.h"

namespace atrium {

// `model` has its patches and clusters; `places` says what of each cluster each lit cell has.
Rows<ClusterId> find_visible(const Bsp& bsp, const std::vector<CellPortal>& lit_portals,
                             const Model& model, std::vector<ClusterInCell> places);

}  // namespace atrium
