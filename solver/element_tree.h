// Growing a patch's element tree: the root from its polygon, and the splitting of a leaf. Where a
// contact line crosses a leaf about its own size, the split runs along it, so that shadows of
// things that stand on the surface, and walls that meet it, end where elements end; else it runs
// through the centroid across the longer extent.
//
// Splitting is a pure function of the tree: the same bits in any thread and on any machine state.
#pragma once

#include "engine/cluster_record.h"
#include "engine/model.h"

namespace atrium {

// The tree of a patch, a single leaf with E = 0.
PatchTree plant(const Model& model, const Scene& scene, PatchId patch, int order);

// Splits leaf i, handing E down exactly. False, with nothing changed, where a child's extent would
// fall below min_edge (m). References into the tree's arrays are invalid afterwards.
bool split_leaf(PatchTree& tree, std::int32_t i, double min_edge);

}  // namespace atrium
