// Patches as the store holds them, for what sums over a whole solution.
// One caller at a time, as with the store.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"

namespace atrium {

// Calls `visit` with each patch of the cluster that receives, its record pinned meanwhile.
Status each_receiver(ClusterStore& store, ClusterId cluster,
                     const std::function<void(const PatchView&)>& visit);

// These clusters are read next, one after the other.
void foresee(ClusterStore& store, std::span<const ClusterId> clusters);

// The same of clusters one after the other, which are foreseen.
Status each_receiver(ClusterStore& store, std::span<const ClusterId> clusters,
                     const std::function<void(ClusterId, const PatchView&)>& visit);

std::vector<ClusterId> all_clusters(const Model& model);  // ascending

// Over an element, lx.
Spectrum mean_irradiance(const PatchView& patch, std::size_t element);

}  // namespace atrium
