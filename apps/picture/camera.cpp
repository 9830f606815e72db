#include "apps/picture/camera.h"

#include <cmath>
#include <numbers>

namespace atrium {

Camera look_at(const Vec3& eye, const Vec3& target, const Vec3& up, double fov) {
  constexpr double kParallel = 1e-6;
  Camera c;
  c.eye = eye;
  c.forward = normalize(target - eye);
  Vec3 right = cross(c.forward, up);
  if (length(right) < kParallel * length(up))
    right = cross(c.forward, std::abs(c.forward.x) < 0.5 ? Vec3(1, 0, 0) : Vec3(0, 1, 0));
  c.right = normalize(right);
  c.up = cross(c.right, c.forward);
  c.half_height = std::tan(fov * std::numbers::pi / 360);
  return c;
}

}  // namespace atrium
