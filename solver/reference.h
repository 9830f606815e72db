// Reference: irradiance with standard errors at many points by path tracing, to a number of paths
// or to a noise. The yardstick for solutions. All results are the same for any number of threads.
//
// Estimates are unbiased whatever the number of paths. Standard errors are estimates too: where a
// rare path brings much (a lamp a centimetre under a ceiling, seen through the gap), a point that
// has met none of them yet is too dark and too sure of it. Thousands of paths a point mend that;
// stopping by a noise stops such points too early.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "solver/path_tracer.h"

namespace atrium {

struct ReferenceOptions {
  std::uint64_t paths = 1024;  // a point; rounded up to the same number in each replicate
  // Above 0: instead, go on until each point's standard error (luminance) is at most this share of
  // the larger of E there and E's mean over all points.
  double noise = 0;
};

struct ReferencePoint {
  Spectrum irradiance{0};      // lx
  Spectrum standard_error{0};  // lx
};

struct ReferenceResult {
  std::vector<ReferencePoint> points;
  std::uint64_t paths = 0, rays = 0;  // the pilot's rays too
  double noise = 0;  // root mean square over points of the standard error's share, as above
};

// Told now and then, from any thread: paths done, and how many are known to be wanted.
using ReferenceProgress = std::function<void(std::uint64_t done, std::uint64_t wanted)>;

ReferenceResult trace_reference(PathTracer& tracer, std::span<const SurfacePoint> points,
                                const ReferenceOptions& options, const ReferenceProgress& progress);

// Points uniform by area over the scene's surfaces, on the front of each, or on the back where that
// alone counts. A point that no light is found for by a few thousand paths is drawn again; fewer
// than `count` where next to nothing is lit.
std::vector<SurfacePoint> draw_lit_points(const PathTracer& tracer, std::uint64_t count,
                                          std::uint64_t seed);

}  // namespace atrium
