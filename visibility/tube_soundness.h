// The judge of tubes: chains of them between patches that the global oracle lets see each other,
// narrowed as the solver narrows them, and segments through the last one. See soundness.h.
// A TubeJudge is immutable; any number of threads may have it judge.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"
#include "visibility/blocker.h"
#include "visibility/occlusion.h"
#include "visibility/patch_sampler.h"
#include "visibility/second_look.h"
#include "visibility/soundness.h"
#include "visibility/tube.h"

namespace atrium {

struct TubeTally {
  TubeCounts counts;
  std::vector<std::string> examples;
};

class TubeJudge {
 public:
  // All outlive the judge; `surfaces` are the scene's, by number, and `rays` is made of them.
  TubeJudge(const Scene& scene, const Model& model, const PatchSampler& sampler,
            const SecondLook& look, std::span<const BlockerPolygon> surfaces, const RayScene& rays);

  // One chain of tubes: none where what was drawn does not face each other.
  void judge(RandomStream& random, TubeTally& tally) const;

 private:
  struct End;
  bool wrongly_invisible(const Vec3& x, const Vec3& y, const End& p, const End& q) const;
  bool wrongly_visible(const Vec3& x, const Vec3& y, const End& p, const End& q) const;
  void shoot(const End& p, const End& q, Variety found, RandomStream& random,
             TubeTally& tally) const;

  const Scene& scene_;
  const Model& model_;
  const PatchSampler& sampler_;
  const SecondLook& look_;
  const RayScene& rays_;
  BlockerIndex index_;
  double finest_ = 0;  // m, of an end whose area is its square: below it is halved no further
};

}  // namespace atrium
