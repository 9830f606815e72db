// Lit scene: a solution to look at with rays. A ray goes through the dark outsides of walls, where
// no light reaches and nothing was solved, so that a closed room can be looked into from outside.
//
// Element trees are read from the run cluster by cluster, when a ray first meets them, and kept.
// Thread safety: any number of threads may trace and shade.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "apps/picture/shaded_patch.h"
#include "scheduler/patch_grid.h"
#include "scheduler/solution.h"
#include "visibility/occlusion.h"

namespace atrium {

struct LitPoint {
  PatchId patch;
  Vec3 x{0};
  double t = 0;    // along the ray, in lengths of its direction
  int passed = 0;  // dark outsides that the ray went through
};

class LitScene {
 public:
  explicit LitScene(Solution& solution);

  const RunModel& run() const { return solution_.run(); }
  std::optional<LitPoint> first_lit(const Vec3& origin, const Vec3& direction, double near) const;
  // Read at the first call for any patch of its cluster.
  Result<const ShadedPatch*> shaded(PatchId patch);

 private:
  using Shaded = std::vector<ShadedPatch>;  // of one cluster
  Result<const Shaded*> load(ClusterId cluster);

  Solution& solution_;
  RayScene rays_;
  PatchGrid grid_;
  std::mutex mutex_;  // of the solution and of `shaded_`'s writing
  std::vector<std::unique_ptr<Shaded>> shaded_;
  std::vector<std::atomic<const Shaded*>> ready_;
};

}  // namespace atrium
