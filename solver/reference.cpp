#include "solver/reference.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

#include "visibility/patch_sampler.h"

namespace atrium {
namespace {

// The pilot's share of all paths, within limits: among hundreds of lamps it is earned back twice.
// To a noise, as if each point took so many.
constexpr std::uint64_t kPathsAPilotPath = 8, kPathsToANoise = 1024;
constexpr std::uint64_t kLeastPilotPaths = 1u << 14, kMostPilotPaths = 1u << 19;

// To a noise: a first round tells how noisy each point is; later ones go on to what that predicts,
// never to more than so many times what is there, and always by a little more.
constexpr std::uint32_t kFirstRound = 16;  // paths a replicate
constexpr double kMostGrowth = 4, kPredictionSlack = 1.1;

// Is a point lit? So many paths a replicate at most, one at first; those of the test are never the
// estimate's.
constexpr std::uint32_t kLitPaths = 128;
constexpr std::uint64_t kLitLabel = 0x6c6974;
constexpr int kDrawRounds = 64;

// Luminance of a standard error whose channels go together, as compare.py has it.
double share_of(const PointSums& point, double mean) {
  return luminance(point.standard_error()) / std::max(luminance(point.mean()), mean);
}

double mean_luminance(std::span<const PointSums> points) {
  double sum = 0;
  for (const PointSums& p : points) sum += luminance(p.mean());
  return points.empty() ? 0 : sum / static_cast<double>(points.size());
}

// Rounds over all points, each to its own number of paths.
class Rounds {
 public:
  Rounds(const PathTracer& tracer, std::span<const SurfacePoint> points,
         const ReferenceProgress& progress)
      : tracer_(tracer),
        points_(points),
        progress_(progress),
        sums_(points.size()),
        rays_(points.size()) {}

  void run(std::span<const std::uint32_t> targets) {
    const std::uint64_t wanted =
        kReplicates * std::accumulate(targets.begin(), targets.end(), std::uint64_t{0});
    tbb::parallel_for(std::size_t{0}, points_.size(), [&](std::size_t i) {
      const std::uint32_t before = sums_[i].paths;
      rays_[i] += tracer_.trace(points_[i], i, targets[i], sums_[i]);
      done_ += std::uint64_t{kReplicates} * (sums_[i].paths - before);
      if (progress_) progress_(done_, wanted);
    });
  }

  // Where each point should go for this noise; false where all are there.
  bool raise(double noise, std::vector<std::uint32_t>& targets) const {
    const double mean = mean_luminance(sums_);
    bool any = false;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const double excess = share_of(sums_[i], mean) / noise;
      if (!(excess > 1)) continue;
      any = true;
      const double growth = std::min(kMostGrowth, kPredictionSlack * excess * excess);
      targets[i] =
          sums_[i].paths + kFirstRound * static_cast<std::uint32_t>(std::ceil(
                                             (growth - 1) * sums_[i].paths / double(kFirstRound)));
    }
    return any;
  }

  ReferenceResult result() const {
    ReferenceResult r;
    const double mean = mean_luminance(sums_);
    double squares = 0;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      r.points.push_back({sums_[i].mean(), sums_[i].standard_error()});
      r.paths += std::uint64_t{kReplicates} * sums_[i].paths;
      r.rays += rays_[i];
      const double share = mean > 0 ? share_of(sums_[i], mean) : 0;
      squares += share * share;
    }
    if (!sums_.empty()) r.noise = std::sqrt(squares / static_cast<double>(sums_.size()));
    return r;
  }

 private:
  const PathTracer& tracer_;
  std::span<const SurfacePoint> points_;
  const ReferenceProgress& progress_;
  std::vector<PointSums> sums_;
  std::vector<std::uint64_t> rays_;
  std::atomic<std::uint64_t> done_{0};
};

// Surfaces by area, each once.
class SurfaceSampler {
 public:
  explicit SurfaceSampler(const Scene& scene) : scene_(scene) {
    for (const Surface& s : scene.surfaces) {
      if (s.sides == kNoSide) continue;
      surfaces_.push_back(&s);
      total_ += area(scene.polygon(s));
      area_up_to_.push_back(total_);
    }
  }
  bool empty() const { return surfaces_.empty(); }
  SurfacePoint draw(RandomStream& random) const {
    const double at = random.uniform() * total_;
    const auto up_to = std::upper_bound(area_up_to_.begin(), area_up_to_.end() - 1, at);
    const Surface& s = *surfaces_[static_cast<std::size_t>(up_to - area_up_to_.begin())];
    const Vec3 normal = plane_of(scene_.polygon(s)).normal;
    return {point_of(scene_.polygon(s), random.square()), s.sides & kFront ? normal : -normal};
  }

 private:
  const Scene& scene_;
  std::vector<const Surface*> surfaces_;
  std::vector<double> area_up_to_;  // m²
  double total_ = 0;
};

bool is_lit(const PathTracer& tracer, const SurfacePoint& point, std::uint64_t number) {
  PointSums sums;
  for (std::uint32_t paths = 1; paths <= kLitPaths; paths *= 2) {
    tracer.trace(point, derived(kLitLabel, number), paths, sums);
    const Spectrum found = sums.mean();
    if (found.x > 0 || found.y > 0 || found.z > 0) return true;
  }
  return false;
}

}  // namespace

ReferenceResult trace_reference(PathTracer& tracer, std::span<const SurfacePoint> points,
                                const ReferenceOptions& options,
                                const ReferenceProgress& progress) {
  const bool to_noise = options.noise > 0;
  const std::uint64_t pilot =
      std::clamp(points.size() * (to_noise ? kPathsToANoise : options.paths) / kPathsAPilotPath,
                 kLeastPilotPaths, kMostPilotPaths);
  const std::uint64_t pilot_rays = tracer.learn(points, pilot);
  Rounds rounds(tracer, points, progress);
  const std::uint64_t paths = (options.paths + kReplicates - 1) / kReplicates;
  std::vector<std::uint32_t> targets(points.size(),
                                     to_noise ? kFirstRound : static_cast<std::uint32_t>(paths));
  rounds.run(targets);
  while (to_noise && rounds.raise(options.noise, targets)) rounds.run(targets);
  ReferenceResult result = rounds.result();
  result.rays += pilot_rays;
  return result;
}

std::vector<SurfacePoint> draw_lit_points(const PathTracer& tracer, std::uint64_t count,
                                          std::uint64_t seed) {
  std::vector<SurfacePoint> lit;
  const SurfaceSampler sampler(tracer.scene().scene());
  if (sampler.empty()) return lit;
  RandomStream random(seed, 0);
  std::uint64_t drawn = 0;
  for (int round = 0; round < kDrawRounds && lit.size() < count; ++round) {
    std::vector<SurfacePoint> candidates(count - lit.size());
    for (SurfacePoint& c : candidates) c = sampler.draw(random);
    std::vector<char> keep(candidates.size());
    tbb::parallel_for(std::size_t{0}, candidates.size(),
                      [&](std::size_t i) { keep[i] = is_lit(tracer, candidates[i], drawn + i); });
    for (std::size_t i = 0; i < candidates.size(); ++i)
      if (keep[i]) lit.push_back(candidates[i]);
    drawn += candidates.size();
  }
  return lit;
}

}  // namespace atrium
