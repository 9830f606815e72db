#include "scheduler/patch_grid.h"

#include <algorithm>
#include <cmath>

namespace atrium {

namespace {

double distance_outside(PolygonView polygon, const Vec3& normal, const Vec3& x) {
  double worst = 0;
  const std::size_t n = polygon.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 edge = polygon[(i + 1) % n] - polygon[i];
    const double l = length(edge);
    if (l > 0) worst = std::max(worst, -dot(cross(edge, x - polygon[i]), normal) / l);
  }
  return worst;
}

}  // namespace

PatchGrid::PatchGrid(const Model& model, const Box& bounds, double margin)
    : model_(&model), box_(bounds), margin_(margin) {
  constexpr double kBinsPerPatch = 8;
  const double n = std::max<double>(1, static_cast<double>(model.patches.size()));
  step_ = std::max(box_.diagonal() / std::cbrt(kBinsPerPatch * n), 4 * margin);
  if (!(step_ > 0)) step_ = 1;
  for (int k = 0; k < 3; ++k) size_[k] = 1 + static_cast<int>((box_.hi[k] - box_.lo[k]) / step_);
  const std::size_t count = static_cast<std::size_t>(size_[0]) * size_[1] * size_[2];
  std::vector<std::vector<PatchId>> bins(count);
  for (std::size_t p = 0; p < model.patches.size(); ++p) {
    const Box b = atrium::bounds(model.polygon(model.patches[p]));
    const std::array<int, 3> lo = at(b.lo - Vec3{margin}), hi = at(b.hi + Vec3{margin});
    for (int z = lo[2]; z <= hi[2]; ++z)
      for (int y = lo[1]; y <= hi[1]; ++y)
        for (int x = lo[0]; x <= hi[0]; ++x) bins[index({x, y, z})].push_back(PatchId(p));
  }
  for (const std::vector<PatchId>& bin : bins) rows_.push_row(bin);
}

std::array<int, 3> PatchGrid::at(const Vec3& x) const {
  std::array<int, 3> i;
  for (int k = 0; k < 3; ++k)
    i[k] = std::clamp(static_cast<int>(std::floor((x[k] - box_.lo[k]) / step_)), 0, size_[k] - 1);
  return i;
}

std::optional<PatchId> PatchGrid::find(const Vec3& x, const Vec3& normal, double tolerance) const {
  constexpr double kSameSide = 0.5;  // cosine
  std::optional<PatchId> best;
  double best_distance = tolerance;
  for (const PatchId id : rows_[index(at(x))]) {
    const Patch& p = model_->patches[id.value];
    const PolygonView polygon = model_->polygon(p);
    const Plane plane = plane_of(polygon);
    if (dot(plane.normal, normal) < kSameSide) continue;
    const double off = std::abs(plane.distance(x));
    if (off > best_distance) continue;
    const double distance = std::max(off, distance_outside(polygon, plane.normal, x));
    if (distance > best_distance) continue;
    if (best && distance == best_distance && (p.inert || !model_->patches[best->value].inert))
      continue;
    best = id;
    best_distance = distance;
  }
  return best;
}

}  // namespace atrium
