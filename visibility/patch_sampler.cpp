#include "visibility/patch_sampler.h"

#include <algorithm>

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

Vec2 RandomStream::square() {
  const double x = uniform();
  return {x, uniform()};
}

std::size_t RandomStream::below(std::size_t count) {
  return static_cast<std::size_t>(uniform() * static_cast<double>(count));
}

PatchSampler::PatchSampler(const Model& model) : model_(model) {
  planes_.reserve(model.patches.size());
  for (const Patch& p : model.patches) planes_.push_back(plane_of(model.polygon(p)));
  double sum = 0;
  for (const Cluster& c : model.clusters) {
    first_of_cluster_.push_back(triangles_.size());
    for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
      if (!model.patches[p].inert) add_triangles(PatchId(p), sum);
  }
  first_of_cluster_.push_back(triangles_.size());
  area_before_.push_back(sum);
  lay_guide();
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c)
    if (lit(ClusterId(c))) lit_clusters_.push_back(ClusterId(c));
}

// The fan around the first corner, those without area left out.
void PatchSampler::add_triangles(PatchId patch, double& sum) {
  const Patch& p = model_.patches[patch.value];
  const PolygonView polygon = model_.polygon(p);
  for (std::uint32_t i = 2; i < p.vertex_count; ++i) {
    const double part = fan_area(polygon, i);
    if (!(sum + part > sum)) continue;
    triangles_.push_back({patch, {p.first_vertex, p.first_vertex + i - 1, p.first_vertex + i}});
    area_before_.push_back(sum);
    sum += part;
  }
}

bool PatchSampler::lit(ClusterId cluster) const {
  return first_of_cluster_[cluster.value] < first_of_cluster_[cluster.value + 1];
}

// Searching all triangles would miss the caches at every step: as many equal parts of the area as
// there are triangles each know where to begin. [Chen & Asau 1974]
void PatchSampler::lay_guide() {
  const double part = area_before_.back() / double(triangles_.size());
  std::size_t at = 0;
  for (std::size_t i = 0; i <= triangles_.size(); ++i) {
    while (at + 1 < triangles_.size() && area_before_[at + 1] <= double(i) * part) ++at;
    guide_.push_back(at);
  }
}

// Of the triangles [first, last), the last one that begins at or before `area`.
PatchPoint PatchSampler::point_at(double area, std::size_t first, std::size_t last,
                                  RandomStream& random) const {
  const double* before = area_before_.data();
  const double* next = std::upper_bound(before + first + 1, before + last, area);
  const Triangle& t = triangles_[static_cast<std::size_t>(next - before - 1)];
  const auto corner = [&](int k) { return model_.vertices[t.corners[k]]; };
  return {t.patch, point_of(corner(0), corner(1), corner(2), random.square())};
}

PatchPoint PatchSampler::pick(std::size_t first, std::size_t last, RandomStream& random) const {
  ATRIUM_CHECK(first < last);
  const double from = area_before_[first], to = area_before_[last];
  return point_at(from + random.uniform() * (to - from), first, last, random);
}

PatchPoint PatchSampler::by_area(RandomStream& random) const {
  const double at = random.uniform();
  const auto part = static_cast<std::size_t>(at * double(triangles_.size()));
  return point_at(at * area_before_.back(), guide_[part], guide_[part + 1] + 1, random);
}

PatchPoint PatchSampler::by_cluster(RandomStream& random) const {
  return of_cluster(lit_clusters_[random.below(lit_clusters_.size())], random);
}

PatchPoint PatchSampler::of_cluster(ClusterId cluster, RandomStream& random) const {
  return pick(first_of_cluster_[cluster.value], first_of_cluster_[cluster.value + 1], random);
}

}  // namespace atrium
