// Solution: a run directory opened for reading, for probes, pictures and exports. Geometry and
// names stay in memory; element trees are read from the page store cluster by cluster through a
// small arena of its own.
//
// Not thread safe: one caller at a time. Views are valid until the next call.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/model.h"
#include "engine/scene.h"
#include "engine/status.h"
#include "scheduler/fresh_gather.h"

namespace atrium {

// What a run needs to know of its scene and partition beside the cluster records.
struct RunModel {
  SceneFrame frame;
  Box bounds;            // internal frame
  double tolerance = 0;  // m
  int order = 1;         // of the basis
  std::vector<std::string> files;
  std::vector<std::string> object_names;    // by ObjectId
  std::vector<std::string> material_names;  // by MaterialId
  Model model;                              // all of it, contacts apart
};

// What stands at a point of a surface.
struct SurfaceSample {
  Spectrum irradiance{0};  // lx
  Spectrum radiosity{0};   // lm/m²
  Spectrum reflectance{0};
  ClusterId cluster;
  CellId cell;
};

class Solution {
 public:
  // arena_bytes: for cluster records while reading.
  static Result<std::unique_ptr<Solution>> open(const std::string& run_directory,
                                                std::size_t arena_bytes);
  ~Solution();

  const RunModel& run() const;
  const std::string& summary_json() const;  // the text of summary.json, "" if there is none

  // Calls `visit` with each cluster in order, its record pinned meanwhile.
  Status for_each_cluster(const std::function<void(ClusterId, const ClusterView&)>& visit);
  // One cluster; the view holds until the next call of any of these.
  Result<ClusterView> cluster(ClusterId id);

  // The patch side that the point (m, internal frame) lies on within `tolerance`, seen from the
  // side the normal points to; none if there is none.
  std::optional<PatchId> patch_at(const Vec3& x, const Vec3& normal, double tolerance) const;
  // The cell the point lies in, a little off the surface along the normal; invalid if in none.
  CellId cell_at(const Vec3& x, const Vec3& normal) const;
  // E and B of a patch at a point of it.
  Result<SurfaceSample> sample(PatchId patch, const Vec3& x);
  // E gathered at points with rays from the solution itself, in their order. [final gather]
  Result<std::vector<FreshIrradiance>> final_gather(std::span<const GatherPoint> points,
                                                    const FreshSettings& settings);

 private:
  Solution();
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// E of an element's polynomial at p, lx: as it was solved, and as it is shown.
Spectrum polynomial_at(const PatchView& patch, std::int32_t element, const Vec2& p);
Spectrum irradiance_at(const PatchView& patch, std::int32_t element, const Vec2& p);

}  // namespace atrium
