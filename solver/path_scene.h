// PathScene: what a path meets in an imported scene. The ray structure over all surfaces, what
// stands on the side that a ray arrives at, and the emitters with points on them. It knows the
// scene alone: no cells, no oracle, no elements.
//
// Of a side that does not count, a coplanar surface that counts there answers in its place
// (Scene's invariant 2); where there is none the side is opaque and black.
//
// The scene must outlive it. Immutable once built; any number of threads may query.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"
#include "solver/light_tree.h"
#include "visibility/box_tree.h"
#include "visibility/occlusion.h"

namespace atrium {

inline constexpr std::uint32_t kNoLight = std::numeric_limits<std::uint32_t>::max();

// The side of a surface that a ray arrives at.
struct MetSide {
  Vec3 normal{0};  // unit, against the ray
  Spectrum reflectance{0};
  Spectrum exitance{0};
  std::uint32_t light = kNoLight;
};

struct LightPoint {
  Vec3 x{0};
  Vec3 normal{0};  // of the surface's front
  Spectrum exitance{0};
  double area = 0;  // m², of the light's polygon
  std::uint8_t sides = 0;
};

class PathScene {
 public:
  explicit PathScene(const Scene& scene);

  const Scene& scene() const { return scene_; }
  const RayScene& rays() const { return rays_; }
  const std::vector<LightOutline>& lights() const { return outlines_; }
  double area() const { return area_; }  // m², of all surfaces, once each
  double near() const { return near_; }  // m; a ray meets nothing before

  MetSide met(const Hit& hit, const Vec3& direction) const;
  double light_area(std::uint32_t light) const { return lights_[light].area; }

  // Uniform by area where the square's points are uniform.
  LightPoint light_point(std::uint32_t light, const Vec2& square) const;

  // x moved onto the plane of the surface that it lies on within `tolerance` (m) and that is normal
  // to n; where there is none, x.
  Vec3 on_surface(const Vec3& x, const Vec3& n, double tolerance) const;

 private:
  struct Triangle {
    Vec3 a{0}, b{0}, c{0};
    double before = 0, area = 0;  // m²; the light's triangles before it
  };
  struct Light {
    std::uint32_t surface = 0;
    std::uint32_t first_triangle = 0, triangle_count = 0;
    double area = 0;  // m²
  };
  void add_light(std::uint32_t surface);
  void find_stand_ins();
  std::optional<std::uint32_t> stand_in(std::uint32_t surface, Sides side, const Vec3& x) const;

  const Scene& scene_;
  std::vector<Plane> planes_;  // of surfaces
  BoxTree boxes_;
  RayScene rays_;
  double area_ = 0, near_ = 0;
  std::vector<Light> lights_;
  std::vector<Triangle> triangles_;  // every vertex of a path asks: their areas are kept
  std::vector<LightOutline> outlines_;
  std::vector<std::uint32_t> light_of_surface_;
  Rows<std::uint32_t> stand_ins_;  // a row a surface: those that may count where it does not
};

}  // namespace atrium
