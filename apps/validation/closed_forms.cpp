#include "apps/validation/closed_forms.h"

#include <cmath>
#include <numbers>

namespace atrium {
namespace {

constexpr double kPi = std::numbers::pi;

double square(double x) { return x * x; }

// x log y, which is 0 where x is.
double x_log(double x, double y) { return x == 0 ? 0 : x * std::log(y); }

// f over a rectangle's corners, signed as an integral's bounds are.
template <class F>
double over_corners(Range x, Range y, const F& f) {
  return f(x.hi, y.hi) - f(x.hi, y.lo) - f(x.lo, y.hi) + f(x.lo, y.lo);
}

// The element faces the plane z away, one corner of a x b straight before it.
double under_corner(double a, double b, double z) {
  const double s = std::hypot(a, z), t = std::hypot(b, z);
  return (a / s * std::atan(b / s) + b / t * std::atan(a / t)) / (2 * kPi);
}

// ∫∫ x z / π(x² + y² + z²)² over 0..a × 0..b.
double beside_corner(double a, double b, double z) {
  const double s = std::hypot(a, z);
  return (std::atan(b / z) - z / s * std::atan(b / s)) / (2 * kPi);
}

}  // namespace

double opposite_rectangles(double a, double b, double c) {
  const double x = a / c, y = b / c, s = std::hypot(1, x), t = std::hypot(1, y);
  return 2 / (kPi * x * y) *
         (std::log(s * t / std::hypot(1, x, y)) + x * t * std::atan(x / t) +
          y * s * std::atan(y / s) - x * std::atan(x) - y * std::atan(y));
}

double perpendicular_rectangles(double h, double w, double l) {
  const double p = square(h / l), q = square(w / l), s = p + q;
  const auto arc = [](double x2) { return std::sqrt(x2) * std::atan(1 / std::sqrt(x2)); };
  return (arc(q) + arc(p) - arc(s) +
          (std::log((1 + q) * (1 + p) / (1 + s)) + q * std::log(q * (1 + s) / ((1 + q) * s)) +
           p * std::log(p * (1 + s) / ((1 + p) * s))) /
              4) /
         (kPi * std::sqrt(q));
}

double parallel_rectangles(Range x1, Range y1, Range x2, Range y2, double distance) {
  const auto corner = [&](double u, double v) {
    const double s = std::hypot(u, distance), t = std::hypot(v, distance);
    return v * s * std::atan(v / s) + u * t * std::atan(u / t) -
           square(distance) * std::log(std::hypot(u, v, distance));
  };
  const double sum = over_corners(x1, y1, [&](double x, double y) {
    return over_corners(x2, y2, [&](double u, double v) { return corner(u - x, v - y); });
  });
  return sum / (2 * kPi * (x1.hi - x1.lo) * (y1.hi - y1.lo));
}

double floor_to_wall(Range x, Range y1, Range y2, Range z) {
  const auto corner = [](double u, double v, double r2) {
    const double s = std::sqrt(r2), d = v - u;
    return (s == 0 ? 0 : d * s * std::atan(d / s)) - x_log(r2 - d * d, r2 + d * d) / 4;
  };
  const double sum = over_corners(x, y1, [&](double a, double u) {
    return over_corners(z, y2,
                        [&](double c, double v) { return corner(u, v, square(a) + square(c)); });
  });
  return sum / (2 * kPi * (x.hi - x.lo) * (y1.hi - y1.lo));
}

double element_to_parallel(Range x, Range y, double distance) {
  return over_corners(x, y, [&](double a, double b) { return under_corner(a, b, distance); });
}

double element_to_perpendicular(Range x, Range y, double height) {
  return over_corners(x, y, [&](double a, double b) { return beside_corner(a, b, height); });
}

}  // namespace atrium
