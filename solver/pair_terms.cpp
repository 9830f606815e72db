#include "solver/pair_terms.h"

#include <algorithm>
#include <cmath>

#include "engine/squared.h"
#include "visibility/occlusion.h"

namespace atrium {

namespace {

// All of the polygon behind the plane through x with normal n, or on it?
bool behind(std::span<const Vec3> polygon, const Vec3& x, const Vec3& n, double tolerance) {
  for (const Vec3& v : polygon)
    if (dot(n, v - x) > tolerance) return false;
  return true;
}

}  // namespace

bool facing(const Site& a, const Site& b, double tolerance) {
  if (dot(a.normal, b.center - a.center) < -b.radius) return false;
  if (dot(b.normal, a.center - b.center) < -a.radius) return false;
  return !behind(b.polygon(), a.center, a.normal, tolerance) &&
         !behind(a.polygon(), b.center, b.normal, tolerance);
}

namespace {

// How far any of the polygon rises over the plane through x with normal n.
double height_over(std::span<const Vec3> polygon, const Vec3& x, const Vec3& n) {
  double most = 0;
  for (const Vec3& v : polygon) most = std::max(most, dot(n, v - x));
  return most;
}

// Sites that touch are taken to be so far apart, in radii of the source: nothing divides by zero.
constexpr double kNoGap = 1e-6;
// From afar the spheres about two sites tell how far they are apart.
constexpr double kAfar = 4;  // radii

// Not more than the distance between two sites: that of the spheres about them, or, where they are
// close, exact if one of them is small beside the other.
double gap_between(const Site& a, const Site& b) {
  const double distance = length(b.center - a.center), radii = a.radius + b.radius;
  const double spheres = distance - radii;
  if (spheres > kAfar * radii) return spheres;
  const double from_a = length(nearest_point(b, a.center) - a.center) - a.radius;
  const double from_b = length(nearest_point(a, b.center) - b.center) - b.radius;
  return std::max({0.0, spheres, from_a, from_b});
}

}  // namespace

double form_factor_bound(const Site& r, const Site& s) {
  const double gap = std::max(gap_between(r, s), kNoGap * s.radius);
  const double cos_r = std::min(1.0, height_over(s.polygon(), r.center, r.normal) / gap);
  const double cos_s = std::min(1.0, height_over(r.polygon(), s.center, s.normal) / gap);
  const double peak = std::min(1.0, cos_r * cos_s * s.area / (std::numbers::pi * squared(gap)));
  // Where that is reached by a part of the receiver, the whole gets no more than the source sends.
  return std::sqrt(peak * std::min(peak, s.area / r.area));
}

double mean_square_over_source(const Site& r, const Site& s, const Kernel& kernel) {
  double sum = 0;
  for (int l = 0; l < kernel.columns; ++l) {
    double at = 0;
    for (int k = 0; k < kernel.rows; ++k) at += r.weight[k] * kernel.g[k][l];
    sum += squared(at) / s.weight[l];
  }
  return sum;
}

double sensitivity_spread(const Site& r, const Site& s, const Kernel& kernel) {
  const double mean_square = mean_square_over_source(r, s, kernel);
  const Vec3 gap = r.center - nearest_point(s, r.center);
  const double part = std::min(1.0, (r.area + std::numbers::pi * dot(gap, gap)) / s.area);
  return std::sqrt(
      std::max({0.0, mean_square - squared(kernel.mean), (1 - part) * squared(kernel.mean)}));
}

double darkest_row(const Kernel& kernel) {
  return *std::min_element(kernel.row.begin(), kernel.row.begin() + kernel.rows);
}

double largest_factor(const Kernel& kernel) {
  double most = kernel.mean;
  for (const Probe& probe : std::span(kernel.probes).first(kernel.probe_count))
    most = std::max(most, probe.factor);
  return most;
}

double seen_share(const Site& r, const Kernel& open, const Kernel& seen) {
  double part = 0, all = 0;
  for (int k = 0; k < open.rows; ++k)
    for (int l = 0; l < open.columns; ++l) {
      all += r.weight[k] * open.g[k][l];
      part += r.weight[k] * seen.g[k][l];
    }
  return all > 0 ? part / all : 0;
}

double variance_of(double form_factor, double v) {
  const double expected = (kRayLanes * v + 1) / (kRayLanes + 2);
  return squared(form_factor) * expected * (1 - expected) / kRayLanes;
}

}  // namespace atrium
