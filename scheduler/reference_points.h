// Points with known irradiance, and how far a solution is from them: the project's one definition
// of error, |E − E_true| in luminance over the larger of E_true and its mean, root mean square over
// the points, the reference's own noise taken out in quadrature.
#pragma once

#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"

namespace atrium {

class ReferencePoints {
 public:
  // CSV with a header of at least x,y,z,nx,ny,nz,Er,Eg,Eb; seEr,seEg,seEb where known. Errors:
  // kUsage with the line.
  static Result<ReferencePoints> read(const std::string& path, const Scene& scene,
                                      const Model& model);
  // The error over the points that lie on a surface; reads cluster records.
  Result<double> error(const Model& model, ClusterStore& store) const;
  std::size_t size() const { return points_.size(); }

 private:
  struct Point {
    Vec3 x;             // m, internal frame
    PatchId patch;
    double truth = 0;   // lx, luminance
    double noise = 0;   // lx, its standard error
  };
  std::vector<Point> points_;
  double mean_ = 0;
};

}  // namespace atrium
