// Error estimate: how wrong a stored solution is, told from the solution alone.
//
// At random points E is gathered afresh; what that differs by, r = fresh − E, is an unbiased sample
// of the transport equation's residual: of all that refinement left out, of shadows that were
// missed, and of light still on its way, for no sweep need have converged. The solution's error is
// more: e = r + F ρ e, with F the transport of light, since a fresh gather inherits what is wrong
// with its sources. The first part is local and stands at each point; the second is smooth, being a
// mean over all that a point sees, and is solved for on a few groups of clusters, with the same
// rays telling how much of what a group's points receive comes from which group.
//
// In a bright room the second part is many times the first, and its weakest point is the mean of r,
// which noise would spoil. But of that the flux balance tells: without loss ∫ r dA is what is
// emitted less what E says is absorbed, exactly; with loss (to the outdoors, on black backs) up to
// the loss, which the fresh rays measure. It enters as a control variate, with the weight that the
// samples themselves say it deserves. [Cochran 77 §7]
//
// What chance adds is taken off: the fresh gathers' own variance by their replicates, that of the
// smooth part by a jackknife over groups of points, which gives the interval too. [Efron 82] What
// it leaves is noise all the same, and alone may be as much as the error asked: half in the shade
// of a beam, points under a lamp as large as the room know its light to 3% by 128 rays, and 768 of
// them the error to 1%. Then their directions are multiplied.
//
// Errors have heavy tails: a few points hold much of the mean square. No single one is let decide
// it, which would make the estimate jump from seed to seed; the interval's upper end counts all in
// full.
//
// Deterministic in the seed; the same bits for any number of threads and any arena. One caller.
#pragma once

#include <cstdint>

#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/fresh_gather.h"

namespace atrium {

struct EstimateSettings {
  int points = 2048;
  int directions = 256;  // a point, or more where their noise would hide what is asked
  std::uint64_t seed = 1;
  double asked = 0;  // an error that is to be told from none; 0: no matter
};

struct ErrorEstimate {
  // As interface.md defines error: root mean square over area of |E − E_true| ÷ max(E_true, mean).
  double error = 0;
  double low = 0, high = 0;  // 95% confidence
  double local = 0;          // of it, the residual alone: what E differs from its fresh gather
  // (Absorbed + lost) ÷ emitted, by the fresh gathers, and half of its 95% interval.
  double closure = 1, closure_within = 0;
  std::uint64_t points = 0, rays = 0;
  double cpu_seconds = 0;
};

// bright: of the solution as it is stored.
Result<ErrorEstimate> estimate_error(const Model& model, ClusterStore& store, FreshGather& fresh,
                                     const BrightSources& bright,
                                     const EstimateSettings& settings);

}  // namespace atrium
