#include "solver/path_tracer.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "engine/check.h"

namespace atrium {
namespace {

// Numbers of a vertex: direction (2), point on a light (2), which light, survival.
using Numbers = SobolPoint;

// A replicate's points of Sobol's sequence; behind them it starts anew, scrambled otherwise.
constexpr std::uint32_t kSobolPoints = 4096;

// Samples of each replicate that go in one wave.
constexpr std::uint32_t kSamplesAWave = 16;

constexpr std::uint32_t kPilotWave = 512;  // paths
// The pilot looks at lights, not at what comes of them: its paths are cut off.
constexpr int kPilotVertices = 4;

// A path lives on with this times what it still carries: twice, so that first bounces end none
// where surfaces reflect half. Once leaves 25 to 50% more to do for the same noise, four times as
// much in some scenes and less in others.
constexpr double kSurvivalOfCarried = 2;
// It lives on with this probability at least: what dark surfaces still reflect comes in small
// portions and not as rare large ones.
constexpr double kLeastSurvival = 0.05;

// What the seeds of the pilot are apart by.
constexpr std::uint64_t kPilotLabel = 0x70696c6f74;

struct Path {
  Vec3 x{0}, n{0};  // its last vertex, and the side it is on
  Spectrum throughput{1};
  HashStream random;
  std::uint32_t replicate = 0;
};

// A lane's choice of a light, until it is known whether it can be seen.
struct Look {
  std::uint32_t light = 0;
  Spectrum given{0};
};

double sum(const Spectrum& s) { return s.x + s.y + s.z; }
double most(const Spectrum& s) { return std::max({s.x, s.y, s.z}); }

// Both strategies' densities over solid angle, from a vertex towards a point of a light, the
// light's over the cosine's.
double density_ratio(double probability, double area, double d2, double cos_x, double cos_light) {
  return std::numbers::pi * probability * d2 / (area * cos_x * cos_light);
}

// Paths on their way, and what they found.
class Wave {
 public:
  Wave(const PathScene& scene, const LightChoice& choice, std::span<Spectrum> sums,
       std::vector<LightRecord>* records)
      : scene_(scene), choice_(choice), sums_(sums), records_(records) {}

  void clear() { paths_.clear(), numbers_.clear(); }
  void add(const Path& path, const Numbers& first) {
    paths_.push_back(path);
    numbers_.push_back(first);
  }
  // Until every path has ended, or for so many vertices.
  void run(int vertices = std::numeric_limits<int>::max());
  std::uint64_t rays() const { return rays_; }

 private:
  void advance(std::span<Path> paths, std::span<const Numbers> numbers);
  bool look(const Path& path, LightChoice::Region region, const Numbers& u, Look& look,
            Vec3& at) const;
  Spectrum emitted(const Path& path, LightChoice::Region region, const Vec3& direction,
                   const Hit& hit, const MetSide& side) const;
  void draw_numbers();

  const PathScene& scene_;
  const LightChoice& choice_;
  std::span<Spectrum> sums_;  // by replicate
  std::vector<LightRecord>* records_;
  std::vector<Path> paths_;
  std::vector<Numbers> numbers_;
  std::size_t alive_ = 0;
  std::uint64_t rays_ = 0;
};

void Wave::run(int vertices) {
  for (int vertex = 0; vertex < vertices && !paths_.empty(); ++vertex) {
    alive_ = 0;
    for (std::size_t first = 0; first < paths_.size(); first += kRayLanes) {
      const std::size_t count = std::min<std::size_t>(kRayLanes, paths_.size() - first);
      advance(std::span(paths_).subspan(first, count), std::span(numbers_).subspan(first, count));
    }
    paths_.resize(alive_);
    draw_numbers();
  }
}

void Wave::draw_numbers() {
  numbers_.resize(paths_.size());
  for (std::size_t i = 0; i < paths_.size(); ++i)
    for (double& u : numbers_[i]) u = paths_[i].random.uniform();
}

// A packet of paths a vertex further; those that live on move up behind the others that do.
void Wave::advance(std::span<Path> paths, std::span<const Numbers> numbers) {
  std::array<LightChoice::Region, kRayLanes> regions;
  std::array<Look, kRayLanes> looks;
  std::array<Vec3, kRayLanes> directions;
  SegmentPacket shadows;
  RayPacket rays;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const Path& p = paths[i];
    const Numbers& u = numbers[i];
    regions[i] = choice_.region(p.x, p.n);
    Vec3 at;
    if (look(p, regions[i], u, looks[i], at)) shadows.set(static_cast<int>(i), p.x, at);
    directions[i] = cosine_direction(frame_about(p.n), {u[0], u[1]});
    rays.set(static_cast<int>(i), p.x, directions[i], scene_.near());
  }
  std::uint16_t blocked = 0;
  if (shadows.valid != 0) scene_.rays().occluded16(shadows, blocked);
  HitPacket hits;
  scene_.rays().closest_hit16(rays, hits);
  rays_ += paths.size() + static_cast<std::size_t>(std::popcount(shadows.valid));

  const auto seen = static_cast<std::uint16_t>(shadows.valid & ~blocked);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    Path& p = paths[i];
    if (seen >> i & 1) {
      sums_[p.replicate] += p.throughput * looks[i].given;
      if (records_) records_->push_back({p.x, p.n, looks[i].light, sum(looks[i].given)});
    }
    if (!(hits.found >> i & 1)) continue;
    const Hit& hit = hits.hit[i];
    const MetSide side = scene_.met(hit, directions[i]);
    if (side.light != kNoLight)
      sums_[p.replicate] += p.throughput * emitted(p, regions[i], directions[i], hit, side);
    const Spectrum carried = p.throughput * side.reflectance;
    const double survival = std::clamp(kSurvivalOfCarried * most(carried), kLeastSurvival, 1.0);
    if (!(most(carried) > 0) || numbers[i][5] >= survival) continue;
    p.x = hit.point;
    p.n = side.normal;
    p.throughput = carried / survival;
    paths_[alive_++] = p;
  }
}

// The shadow ray's end, and what comes along it if nothing stands between; false if nothing can.
bool Wave::look(const Path& path, LightChoice::Region region, const Numbers& u, Look& look,
                Vec3& at) const {
  const auto chosen = choice_.choose(region, path.x, path.n, u[4]);
  if (!chosen) return false;
  const LightPoint point = scene_.light_point(chosen->light, {u[2], u[3]});
  const Vec3 to = point.x - path.x;
  const double d2 = dot(to, to);
  if (!(d2 > 0)) return false;
  const double d = std::sqrt(d2), cos_x = dot(path.n, to) / d,
               cos_front = -dot(point.normal, to) / d;
  if (!(cos_x > 0) || cos_front == 0) return false;
  if (!(point.sides & (cos_front > 0 ? kFront : kBack))) return false;
  const double r = density_ratio(chosen->probability, point.area, d2, cos_x, std::abs(cos_front));
  look = {chosen->light, point.exitance / (r + 1 / r)};
  at = point.x;
  return true;
}

// What a light sends along a direction that met it, weighed against its shadow rays.
Spectrum Wave::emitted(const Path& path, LightChoice::Region region, const Vec3& direction,
                       const Hit& hit, const MetSide& side) const {
  const double cos_x = dot(path.n, direction), cos_light = -dot(side.normal, direction);
  const double p = choice_.probability(region, path.x, path.n, side.light);
  const double r = density_ratio(p, scene_.light_area(side.light), hit.t * hit.t, cos_x, cos_light);
  return side.exitance / (1 + r * r);
}

}  // namespace

Spectrum PointSums::mean() const {
  const Spectrum all = std::accumulate(sums.begin(), sums.end(), Spectrum{0});
  return paths == 0 ? Spectrum{0} : all / (double(kReplicates) * paths);
}

Spectrum PointSums::standard_error() const {
  if (paths == 0) return Spectrum{0};
  const Spectrum middle = mean();
  Spectrum squares{0};
  for (const Spectrum& s : sums) {
    const Spectrum off = s / double(paths) - middle;
    squares += off * off;
  }
  return glm::sqrt(squares / (double(kReplicates) * (kReplicates - 1)));
}

PathTracer::PathTracer(const Scene& scene, std::uint64_t seed)
    : scene_(scene), choice_(scene_.lights()), sobol_(kSobolPoints), seed_(seed) {}

std::uint64_t PathTracer::trace(const SurfacePoint& point, std::uint64_t number,
                                std::uint32_t paths, PointSums& sums) const {
  const std::uint64_t seed = derived(seed_, number);
  Wave wave(scene_, choice_, sums.sums, nullptr);
  while (sums.paths < paths) {
    const std::uint32_t end = std::min(paths, sums.paths + kSamplesAWave);
    wave.clear();
    for (std::uint32_t r = 0; r < kReplicates; ++r)
      for (std::uint32_t i = sums.paths; i < end; ++i) {
        const std::uint64_t scramble = derived(derived(seed, r), i / kSobolPoints);
        const HashStream random(derived(scramble, i));
        wave.add({point.x, point.normal, Spectrum{1}, random, r},
                 sobol_.scrambled(i % kSobolPoints, scramble));
      }
    wave.run();
    sums.paths = end;
  }
  return wave.rays();
}

std::uint64_t PathTracer::learn(std::span<const SurfacePoint> points, std::uint64_t paths) {
  struct Part {
    std::vector<LightRecord> records;
    std::uint64_t rays = 0;
  };
  if (points.empty() || scene_.lights().size() < 2) return 0;
  std::vector<Part> parts((paths + kPilotWave - 1) / kPilotWave);
  const std::uint64_t seed = derived(seed_, kPilotLabel);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    Spectrum unused{0};
    Wave wave(scene_, choice_, std::span(&unused, 1), &parts[part].records);
    for (std::uint64_t i = part * kPilotWave; i < (part + 1) * kPilotWave; ++i) {
      const SurfacePoint& point = points[i % points.size()];
      Path path{point.x, point.normal, Spectrum{1}, HashStream(derived(seed, i)), 0};
      Numbers first;
      for (double& u : first) u = path.random.uniform();
      wave.add(path, first);
    }
    wave.run(kPilotVertices);
    parts[part].rays = wave.rays();
  });
  std::vector<LightRecord> records;
  std::uint64_t rays = 0;
  for (const Part& part : parts) {
    records.insert(records.end(), part.records.begin(), part.records.end());
    rays += part.rays;
  }
  choice_.learn(records, scene_.area());
  return rays;
}

}  // namespace atrium
