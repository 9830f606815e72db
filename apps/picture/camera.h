// Camera: a pinhole. Pixel coordinates run right and down from the picture's upper left corner.
#pragma once

#include "engine/vec.h"

namespace atrium {

struct Camera {
  Vec3 eye{0};
  Vec3 forward{0, 1, 0}, right{1, 0, 0}, up{0, 0, 1};  // orthonormal
  double half_height = 0.5;  // of the picture at distance 1: the tangent of half the angle of view
  int width = 0, height = 0;

  // The ray through (x, y), of length 1 along `forward`.
  Vec3 direction(double x, double y) const {
    const double scale = 2 * half_height / height;
    return forward + (x - 0.5 * width) * scale * right - (y - 0.5 * height) * scale * up;
  }
  double depth(const Vec3& p) const { return dot(p - eye, forward); }
  // Where a point of positive depth is seen.
  Vec2 project(const Vec3& p) const {
    const double scale = height / (2 * half_height * depth(p));
    return {0.5 * width + dot(p - eye, right) * scale, 0.5 * height - dot(p - eye, up) * scale};
  }
};

// fov: degrees, of the picture's height. `up` is made perpendicular; where it lies along the line
// of sight another is taken.
Camera look_at(const Vec3& eye, const Vec3& target, const Vec3& up, double fov);

}  // namespace atrium
