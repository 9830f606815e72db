// PathTracer: irradiance at a point by unbiased path tracing. At every vertex of a path, light is
// looked for twice: along a shadow ray to a chosen light, and along the cosine-distributed
// direction in which the path goes on; multiple importance sampling weighs both, so that a lamp a
// centimetre under a ceiling is no firefly. [Veach & Guibas 1995, the power heuristic] Russian
// roulette ends paths by what they still carry; nothing is clamped, no depth is cut off.
//
// Paths of a point go in waves: all of them a vertex further, those that live on moved together, so
// that rays go to Embree in full packets.
//
// Invariants:
//  1. Random numbers follow from seed, point, replicate and path; sums of a point run in one order.
//     Who traces which point when changes no bit.
//  2. Replicates of a point are independent of each other, each stratified in itself: from their
//     scatter follows an honest standard error. [randomized quasi-Monte Carlo, Owen 1997]
// The scene must outlive it. trace() is safe from any number of threads, but not beside learn().
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/scene.h"
#include "solver/form_factor.h"
#include "solver/light_choice.h"
#include "solver/path_scene.h"
#include "solver/sample_sequence.h"

namespace atrium {

inline constexpr std::uint32_t kReplicates = 32;

// A point's paths so far: as many in each replicate.
struct PointSums {
  std::array<Spectrum, kReplicates> sums{};  // lx times paths
  std::uint32_t paths = 0;                   // in each replicate

  Spectrum mean() const;
  Spectrum standard_error() const;  // of the mean
};

class PathTracer {
 public:
  PathTracer(const Scene& scene, std::uint64_t seed);

  const PathScene& scene() const { return scene_; }

  // Takes each of the points' replicates to `paths` in all. number: the point's, for its random
  // numbers. Returns the rays cast.
  std::uint64_t trace(const SurfacePoint& point, std::uint64_t number, std::uint32_t paths,
                      PointSums& sums) const;

  // A pilot of so many paths from the points in turn: from then on lights are chosen by what it
  // saw. Returns the rays cast.
  std::uint64_t learn(std::span<const SurfacePoint> points, std::uint64_t paths);

 private:
  PathScene scene_;
  LightChoice choice_;
  SobolTable sobol_;
  std::uint64_t seed_;
};

}  // namespace atrium
