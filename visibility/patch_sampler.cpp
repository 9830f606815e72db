#include "visibility/patch_sampler.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace atrium {

namespace {

std::mt19937_64 engine_of(std::uint64_t seed, std::uint64_t number) {
  std::seed_seq words{seed, seed >> 32, number, number >> 32};  // it takes 32 bits of each
  return std::mt19937_64(words);
}

}  // namespace

RandomStream::RandomStream(std::uint64_t seed, std::uint64_t number)
    : engine_(engine_of(seed, number)) {}

double RandomStream::uniform() {
  constexpr int kMantissa = 53;
  constexpr double kUnit = 1.0 / (std::uint64_t{1} << kMantissa);
  return static_cast<double>(engine_() >> (64 - kMantissa)) * kUnit;
}

std::size_t RandomStream::below(std::size_t count) {
  return static_cast<std::size_t>(uniform() * static_cast<double>(count));
}

Vec3 random_point(PolygonView polygon, RandomStream& random) {
  // The triangle of the fan around the first corner, then a point of it.
  double left = random.uniform() * area(polygon);
  std::size_t i = 2;
  for (; i + 1 < polygon.size(); ++i) {
    const double part = 0.5 * length(cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]));
    if (left < part) break;
    left -= part;
  }
  double s = random.uniform(), t = random.uniform();
  if (s + t > 1) s = 1 - s, t = 1 - t;
  return polygon[0] + s * (polygon[i - 1] - polygon[0]) + t * (polygon[i] - polygon[0]);
}

PatchSampler::PatchSampler(const Model& model) : model_(model) {
  area_before_.reserve(model.patches.size() + 1);
  planes_.reserve(model.patches.size());
  double sum = 0;
  for (const Patch& p : model.patches) {
    area_before_.push_back(sum);
    planes_.push_back(plane_of(model.polygon(p)));
    if (!p.inert) sum += area(model.polygon(p));
  }
  area_before_.push_back(sum);
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c)
    if (lit(ClusterId(c))) lit_clusters_.push_back(ClusterId(c));
}

bool PatchSampler::lit(ClusterId cluster) const {
  const Cluster& c = model_.clusters[cluster.value];
  return area_before_[c.first_patch + c.patch_count] > area_before_[c.first_patch];
}

PatchId PatchSampler::pick(std::size_t first, std::size_t count, RandomStream& random) const {
  const auto begin = area_before_.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(count);
  ATRIUM_CHECK(*end > *begin);
  // The last patch that begins at or before this; rounding up to the whole is the last lit one's.
  const double at =
      std::min(*begin + random.uniform() * (*end - *begin), std::nextafter(*end, *begin));
  const auto behind = std::upper_bound(begin, end, at);
  return PatchId(static_cast<std::size_t>(behind - area_before_.begin() - 1));
}

PatchId PatchSampler::by_area(RandomStream& random) const {
  return pick(0, model_.patches.size(), random);
}

PatchId PatchSampler::by_cluster(RandomStream& random) const {
  return of_cluster(lit_clusters_[random.below(lit_clusters_.size())], random);
}

PatchId PatchSampler::of_cluster(ClusterId cluster, RandomStream& random) const {
  const Cluster& c = model_.clusters[cluster.value];
  return pick(c.first_patch, c.patch_count, random);
}

}  // namespace atrium
