#include "visibility/plane_cluster.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace atrium {

namespace {

// Surfaces below this share of the least area found no plane; they only join one.
constexpr double kFounderShare = 1e-3;
// Buckets of planes: normals and offsets (as a share of the diagonal) within one of these.
constexpr double kBucket = 1e-3;
// Surfaces are taken largest first, in steps of this factor; within a step in the files' order.
constexpr double kAreaStep = 1.09;
// Directions within this angle count as one, and as orthogonal to another.
constexpr double kSameDirection = 0.01;  // rad
constexpr double kOrthogonal = 0.1;      // rad
// Sums of areas that agree to this are equal: the first wins.
constexpr double kSameArea = 1e-6;

using BucketKey = std::array<std::int64_t, 4>;
struct BucketHash {
  std::size_t operator()(const BucketKey& key) const {
    std::uint64_t h = 1469598103934665603ull;
    for (std::int64_t k : key) h = (h ^ static_cast<std::uint64_t>(k)) * 1099511628211ull;
    return h ^ (h >> 29);
  }
};

bool lies_in(const Plane& plane, PolygonView polygon, double tolerance) {
  return std::all_of(polygon.begin(), polygon.end(),
                     [&](const Vec3& x) { return std::abs(plane.distance(x)) <= tolerance; });
}

class PlaneFinder {
 public:
  explicit PlaneFinder(const Scene& scene)
      : scene_(scene), center_(scene.bounds.center()), diagonal_(scene.bounds.diagonal()) {}

  // The plane the surface lies in, made if there is none.
  std::uint32_t find_or_make(const Surface& surface) {
    const PolygonView polygon = scene_.polygon(surface);
    const Plane own = plane_of(polygon);
    const BucketKey key = bucket(own);
    for (std::int64_t i = 0; i < 81; ++i) {
      const BucketKey near{key[0] + i % 3 - 1, key[1] + i / 3 % 3 - 1, key[2] + i / 9 % 3 - 1,
                           key[3] + i / 27 - 1};
      const auto found = buckets_.find(near);
      if (found == buckets_.end()) continue;
      for (std::uint32_t p : found->second)
        if (lies_in(planes[p].plane, polygon, scene_.tolerance)) return p;
    }
    const auto made = static_cast<std::uint32_t>(planes.size());
    planes.push_back({own, frame_of(polygon), 0});
    buckets_[key].push_back(made);
    buckets_[bucket(own.flipped())].push_back(made);
    return made;
  }

  std::vector<CandidatePlane> planes;

 private:
  BucketKey bucket(const Plane& plane) const {
    BucketKey key;
    for (int k = 0; k < 3; ++k)
      key[static_cast<std::size_t>(k)] = std::llround(plane.normal[k] / kBucket);
    key[3] = std::llround(-plane.distance(center_) / (diagonal_ * kBucket));
    return key;
  }

  const Scene& scene_;
  Vec3 center_;
  double diagonal_;
  std::unordered_map<BucketKey, std::vector<std::uint32_t>, BucketHash> buckets_;
};

// The direction most area faces among planes that `counts` says count; zero if none does.
template <class Counts>
Vec3 most_faced(std::span<const CandidatePlane> planes, Counts counts) {
  Vec3 best{0};
  double most = 0;
  for (const CandidatePlane& p : planes) {
    if (!counts(p.plane.normal)) continue;
    double sum = 0;
    for (const CandidatePlane& q : planes)
      if (length(cross(p.plane.normal, q.plane.normal)) < kSameDirection) sum += q.area;
    if (sum > most * (1 + kSameArea)) most = sum, best = p.plane.normal;
  }
  return best;
}

}  // namespace

PlaneClusters cluster_planes(const Scene& scene, double least_area) {
  const std::size_t n = scene.surfaces.size();
  std::vector<double> areas(n);
  std::vector<int> step(n);
  for (std::size_t i = 0; i < n; ++i) {
    areas[i] = area(scene.polygon(scene.surfaces[i]));
    step[i] =
        areas[i] > 0
            ? static_cast<int>(std::floor(std::log(areas[i] / least_area) / std::log(kAreaStep)))
            : std::numeric_limits<int>::min();
  }
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return step[a] > step[b]; });

  constexpr std::uint32_t kNoPlane = ~0u;
  PlaneFinder finder(scene);
  std::vector<std::uint32_t> plane_of_surface(n, kNoPlane);
  std::vector<std::array<double, 2>> faced;
  for (std::uint32_t i : order) {
    if (areas[i] < kFounderShare * least_area) break;
    const std::uint32_t p = plane_of_surface[i] = finder.find_or_make(scene.surfaces[i]);
    faced.resize(finder.planes.size());
    const Vec3 normal = area_vector(scene.polygon(scene.surfaces[i]));
    faced[p][dot(normal, finder.planes[p].plane.normal) > 0] += areas[i];
  }

  PlaneClusters out;
  std::vector<std::uint32_t> kept(finder.planes.size(), kNoPlane);
  for (std::size_t p = 0; p < finder.planes.size(); ++p) {
    finder.planes[p].area = std::max(faced[p][0], faced[p][1]);
    if (finder.planes[p].area < least_area) continue;
    kept[p] = static_cast<std::uint32_t>(out.planes.size());
    out.planes.push_back(finder.planes[p]);
  }
  // Small or slightly skew surfaces that lie in a kept plane cover it all the same.
  for (std::size_t i = 0; i < n; ++i) {
    const PolygonView polygon = scene.polygon(scene.surfaces[i]);
    std::uint32_t p = plane_of_surface[i] == kNoPlane ? kNoPlane : kept[plane_of_surface[i]];
    for (std::uint32_t k = 0; p == kNoPlane && k < out.planes.size(); ++k)
      if (lies_in(out.planes[k].plane, polygon, scene.tolerance)) p = k;
    if (p == kNoPlane) continue;
    const bool along = dot(area_vector(polygon), out.planes[p].plane.normal) > 0;
    out.members.push_back({SurfaceId(i), p, along});
  }
  return out;
}

Frame dominant_frame(std::span<const CandidatePlane> planes, const Vec3& origin) {
  Frame frame;
  frame.origin = origin;
  const Vec3 first = most_faced(planes, [](const Vec3&) { return true; });
  if (!(length(first) > 0)) return frame;
  Vec3 second =
      most_faced(planes, [&](const Vec3& n) { return std::abs(dot(n, first)) < kOrthogonal; });
  if (!(length(second) > 0)) {
    const bool steep = std::abs(first.x) > 0.9;
    second = steep ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
  }
  frame.n = first;
  frame.u = normalize(second - dot(second, first) * first);
  frame.v = cross(frame.n, frame.u);
  return frame;
}

}  // namespace atrium
