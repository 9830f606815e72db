// Local pass: what the links got wrong, measured by rays and mended. Once the sweeps have settled,
// E is gathered afresh at the nodes of every piece (fresh_gather.h): a leaf, or an element that is no
// larger than half the mean leaf and evenly lit, with all leaves in it. Half of a ward's leaves hold
// a hundredth of its area; gathering at each of them took three times as long and left as much
// wrong. Where the light varies, at the rims of its lamps' panels, one mend for all of a piece left
// 1.8% of the ward wrong, and 1.2% as it is done here.
//
// What the fresh gathers differ by from what the links brought is the residual of the transport
// equation: shadows that no segment met, light that was lost on the way; and noise. Along each
// patch's tree it is split into the mean over the patch and the differences between the halves of
// elements, each with its own variance, and each is believed by as much as it stands out of the
// noise: a patch's mean, over thousands of rays, nearly in full, a single piece's only where it is
// large. [local pass: Lischinski, Tampieri & Greenberg 93 §4; shrinkage of wavelet coefficients:
// Donoho & Johnstone 95]
//
// In two sweeps, so that what is measured is all of one solution, whatever the order and wherever a
// run is stopped: the first writes what is to be mended to records beside the clusters', the second
// puts it in. What a mend sends on to other patches is carried by the coarse system
// (equilibrium.h).
//
// One caller; a function of the solution, the settings and the seed alone.
#pragma once

#include <cstdint>

#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/equilibrium.h"
#include "scheduler/fresh_gather.h"
#include "scheduler/gather_cluster.h"

namespace atrium {

// Of the mean leaf's area, what a piece's may be that is none itself.
inline constexpr double kPieceOfLeaf = 0.5;

struct LocalSettings {
  double piece = 0;     // m², elements that are no larger are not told apart within
  int directions = 48;  // a node of a piece
  std::uint64_t seed = 1;
};

// m², over all that receives.
Result<double> mean_leaf_area(const Model& model, ClusterStore& store);

// The first sweep's part for one cluster.
Result<GatherReport> measure_mend(ClusterStore& store, FreshGather& fresh,
                                  const BrightSources& bright, ClusterId id,
                                  const LocalSettings& settings, Equilibrium& equilibrium);

// The second's: the cluster's record, its sums and how many elements it holds.
Result<GatherReport> put_in_mend(ClusterStore& store, ClusterId id, Equilibrium& equilibrium);

// Once it is in, and no more is needed of it.
void drop_mend(ClusterStore& store, ClusterId id);

}  // namespace atrium
