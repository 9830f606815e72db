#include "apps/picture/lit_scene.h"

#include <algorithm>

namespace atrium {
namespace {

// Surfaces in one plane differ by less than this many tolerances.
constexpr double kSamePlane = 10;
constexpr int kMostPassed = 256;  // dark outsides in one ray's way

std::vector<BlockerPolygon> polygons_of(const Model& model) {
  std::vector<BlockerPolygon> polygons;
  for (std::size_t p = 0; p < model.patches.size(); ++p)
    polygons.push_back({model.polygon(model.patches[p]), static_cast<std::uint32_t>(p)});
  return polygons;
}

}  // namespace

LitScene::LitScene(Solution& solution)
    : solution_(solution),
      rays_(polygons_of(solution.run().model)),
      grid_(solution.run().model, solution.run().bounds, kSamePlane * solution.run().tolerance),
      shaded_(solution.run().model.clusters.size()),
      ready_(solution.run().model.clusters.size()) {}

std::optional<LitPoint> LitScene::first_lit(const Vec3& origin, const Vec3& direction,
                                            double near) const {
  const double tolerance = kSamePlane * run().tolerance, unit = length(direction);
  double from = near * unit;
  for (int passed = 0; passed < kMostPassed; ++passed) {
    const std::optional<Hit> hit = rays_.closest_hit(origin, direction, from);
    if (!hit) return std::nullopt;
    if (dot(hit->normal, direction) < 0)
      return LitPoint{PatchId(hit->id), hit->point, hit->t / unit, passed};
    // Its other side may be another patch; where there is none it is dark.
    const std::optional<PatchId> other = grid_.find(hit->point, -hit->normal, tolerance);
    if (other) return LitPoint{*other, hit->point, hit->t / unit, passed};
    from = hit->t + tolerance;
  }
  return std::nullopt;
}

Result<const LitScene::Shaded*> LitScene::load(ClusterId cluster) {
  std::atomic<const Shaded*>& ready = ready_[cluster.value];
  if (const Shaded* made = ready.load(std::memory_order_acquire)) return made;
  const std::lock_guard lock(mutex_);
  if (const Shaded* made = ready.load(std::memory_order_relaxed)) return made;
  const Result<ClusterView> view = solution_.cluster(cluster);
  if (!view.ok()) return view.status();
  auto made = std::make_unique<Shaded>(shade(*view, run().tolerance));
  ready.store(made.get(), std::memory_order_release);
  shaded_[cluster.value] = std::move(made);
  return ready.load(std::memory_order_relaxed);
}

Result<const ShadedPatch*> LitScene::shaded(PatchId patch) {
  const ClusterId cluster = run().model.patches[patch.value].cluster;
  const Result<const Shaded*> of_cluster = load(cluster);
  if (!of_cluster.ok()) return of_cluster.status();
  return &(**of_cluster)[patch.value - run().model.clusters[cluster.value].first_patch];
}

}  // namespace atrium
