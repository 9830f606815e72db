// Relight: light that comes to a cluster beside gathers across links becomes part of its record:
// what is pending of its units (equilibrium.h), the same all over each, and what rays have measured
// on its leaves (local_pass.h). Only the light changes, never an element.
//
// Functions of their arguments; the record is the caller's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "pagestore/cluster_store.h"
#include "scheduler/equilibrium.h"
#include "solver/push_pull.h"

namespace atrium {

// Adds to a patch's E, lx, what comes to all of its places, then its mends: K coefficients to each
// leaf, in the elements' order; none: nothing is mended. A channel whose mean would be negative on a
// leaf becomes 0 there. The sums tell what mends have changed, and nothing of the other; gains too,
// as push_pull has them.
PushPullSums relight(PatchTree& tree, const PlacedLight& light, std::size_t patch,
                     std::span<const Spectrum> mends, std::span<PlaceGain> gains = {});

struct Relit {
  PushPullSums sums;             // over the patches that are not inert
  std::vector<PatchGain> gains;  // by patch: by mends
  std::uint64_t elements = 0;
};

// How many coefficients its mends are, those of inert patches being none.
std::size_t mend_count(const ClusterView& cluster);

// The same with a cluster, which `before` is a view of: mends all or none.
Relit relight(const ClusterView& before, ClusterEdit& record, const PlacedLight& light,
              std::span<const Spectrum> mends = {});

}  // namespace atrium
