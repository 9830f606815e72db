// Random patches and points on them, for judges that draw segments through lit space. Only patches
// that receive and send light are drawn: they border cells that light reaches, black backs do not
// look.
// RandomStream belongs to one thread; a PatchSampler is immutable once built.
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "engine/model.h"

namespace atrium {

// Random numbers of their own for each pair of seed and number: what is drawn does not depend on
// who draws it, nor when.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t number);
  double uniform();                      // [0, 1)
  Vec2 square();                         // [0, 1)²
  std::size_t below(std::size_t count);  // 0, 1, … count - 1

 private:
  std::mt19937_64 engine_;
};

// A random point of a patch.
struct PatchPoint {
  PatchId patch;
  Vec3 at{0};
};

class PatchSampler {
 public:
  explicit PatchSampler(const Model& model);

  // Clusters of which some patch is lit, in the model's order.
  const std::vector<ClusterId>& lit_clusters() const { return lit_clusters_; }
  bool lit(ClusterId cluster) const;

  // There must be a lit cluster.
  PatchPoint by_area(RandomStream& random) const;     // of all lit patches
  PatchPoint by_cluster(RandomStream& random) const;  // each lit cluster alike, then by area
  PatchPoint of_cluster(ClusterId cluster, RandomStream& random) const;  // a lit one, by area

  const Plane& plane(PatchId patch) const { return planes_[patch.value]; }

 private:
  struct Triangle {
    PatchId patch;
    std::array<std::uint32_t, 3> corners;  // of the model's vertices
  };
  void add_triangles(PatchId patch, double& sum);
  void lay_guide();
  PatchPoint pick(std::size_t first, std::size_t last, RandomStream& random) const;
  PatchPoint point_at(double area, std::size_t first, std::size_t last, RandomStream& random) const;

  const Model& model_;
  std::vector<ClusterId> lit_clusters_;
  std::vector<Plane> planes_;        // of patches
  std::vector<Triangle> triangles_;  // of lit patches, in their order
  std::vector<double> area_before_;  // m², of the triangles before each, and the whole
  std::vector<std::size_t> guide_;   // where in area_before_ each of so many equal parts begins
  std::vector<std::size_t> first_of_cluster_;  // its first triangle; at the end their number
};

}  // namespace atrium
