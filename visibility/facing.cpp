#include "visibility/facing.h"

#include <algorithm>

namespace atrium {

Facing::Facing(const Model& model) : model_(model) {
  planes_.reserve(model.patches.size());
  for (const Patch& p : model.patches) planes_.push_back(plane_of(model.polygon(p)));
}

bool Facing::rises(const Box& box, const Plane& plane) const {
  Vec3 farthest;
  for (int k = 0; k < 3; ++k) farthest[k] = plane.normal[k] > 0 ? box.hi[k] : box.lo[k];
  return plane.distance(farthest) > model_.tolerance;
}

bool Facing::rises(std::uint32_t patch, const Plane& plane) const {
  const PolygonView polygon = model_.polygon(model_.patches[patch]);
  return std::any_of(polygon.begin(), polygon.end(),
                     [&](const Vec3& x) { return plane.distance(x) > model_.tolerance; });
}

bool Facing::faces_box(std::uint32_t cluster, const Box& box) const {
  const Cluster& c = model_.clusters[cluster];
  for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
    if (rises(box, planes_[p])) return true;
  return false;
}

bool Facing::may_see(std::uint32_t c, std::uint32_t d) const {
  const Cluster &a = model_.clusters[c], &b = model_.clusters[d];
  if (!faces_box(c, b.bounds) || !faces_box(d, a.bounds)) return false;
  for (std::uint32_t p = a.first_patch; p < a.first_patch + a.patch_count; ++p) {
    if (!rises(b.bounds, planes_[p])) continue;
    for (std::uint32_t q = b.first_patch; q < b.first_patch + b.patch_count; ++q) {
      if (model_.patches[p].inert && model_.patches[q].inert) continue;
      if (rises(p, planes_[q]) && rises(q, planes_[p])) return true;
    }
  }
  return false;
}

}  // namespace atrium
