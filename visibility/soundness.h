// The oracles' judge: random segments between points of lit patches, held against all surfaces.
//
//  1. Of the global oracle: clusters that a free segment joins are in each other's rows; and what a
//     blocked one meets first is in the row it starts from, for rows serve as lists of blockers.
//     Both witness that the two see each other.
//  2. Of tubes: no segment gets through one that is called INVISIBLE, and nothing blocks one
//     through a tube called VISIBLE.
// Sight through gaps that the model was asked to close is exempt, and counted: a segment that would
// accuse a row and passes through one, or within the second look's width of it.
//
// Half of the segments have both ends uniform by area; of the other half both clusters are drawn
// alike, then points in them by area. Ends that lie behind each other are drawn again, a few times.
//
// Rays in float look first. Whom they accuse, and the first witness that they call for a pair of
// clusters, gets a second look in double; what stays in doubt is no evidence (second_look.h). So
// crowded ends, cracks below the scene's tolerance and Embree's slips between faces that share no
// corner accuse nobody. A verdict on a blocker needs that it is met for certain, in front of the
// start's plane, and that no other surface is before it; one against VISIBLE, that what blocks lies
// deeper in the shaft than the tolerance excuses.
//
// Deterministic for any number of threads.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"

namespace atrium {

struct SoundnessOptions {
  std::uint64_t segments = 1'000'000;
  std::uint64_t seed = 1;
  std::uint64_t tubes = 10'000;  // chains of tubes, each narrowed to a random depth
};

// Unordered pairs of clusters that both have a lit patch.
struct PairCounts {
  std::uint64_t kept = 0;       // in the global oracle's rows
  std::uint64_t witnessed = 0;  // of them, those of which a segment shows that they see each other
  double ratio() const { return witnessed > 0 ? double(kept) / double(witnessed) : 0; }
};

struct TubeCounts {
  std::uint64_t invisible = 0, visible = 0, partial = 0;
  std::uint64_t wrongly_invisible = 0, wrongly_visible = 0;  // segments that say so
};

struct SoundnessReport {
  std::uint64_t joined = 0, blocked = 0;  // segments; the others' ends never faced each other
  std::uint64_t missed_sources = 0, missed_blockers = 0;  // segments that say so
  std::uint64_t exempt = 0;   // of segments that would have said so: through closed gaps
  PairCounts others, selves;  // pairs of two clusters, and of a cluster with itself
  double mean_share = 0, largest_share = 0;  // of all clusters, in a lit cluster's row
  TubeCounts tubes;
  std::vector<std::string> examples;  // the first violations of each kind, in words

  PairCounts pairs() const {
    return {others.kept + selves.kept, others.witnessed + selves.witnessed};
  }
  std::uint64_t violations() const {
    return missed_sources + missed_blockers + tubes.wrongly_invisible + tubes.wrongly_visible;
  }
};

SoundnessReport judge_visibility(const Scene& scene, const Model& model,
                                 const SoundnessOptions& options = {});

}  // namespace atrium
