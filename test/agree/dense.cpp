#include "test/agree/dense.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/check.h"
#include "engine/geometry.h"
#include "solver/form_factor.h"

namespace atrium::testing {

namespace {

constexpr std::size_t kPartners = 4;  // segments that leave each sample point

// Halves a polygon across its longest edge's direction until none of its edges exceeds `edge`.
void cut_up(const Polygon& polygon, double edge, double tolerance, std::vector<Polygon>& out) {
  std::size_t longest = 0;
  const auto side = [&](std::size_t i) { return polygon[(i + 1) % polygon.size()] - polygon[i]; };
  for (std::size_t i = 1; i < polygon.size(); ++i)
    if (length(side(i)) > length(side(longest)) * (1 + 1e-9)) longest = i;
  if (length(side(longest)) <= edge) {
    out.push_back(polygon);
    return;
  }
  const Vec3 n = normalize(side(longest));
  const Split halves = split(polygon, {n, dot(n, centroid(polygon))}, tolerance);
  cut_up(halves.front, edge, tolerance, out);
  cut_up(halves.back, edge, tolerance, out);
}

struct Sample {
  Vec3 x{0};
  double weight = 0;
};

void sample_triangle(const Vec3& a, const Vec3& b, const Vec3& c, int depth,
                     std::vector<Sample>& out) {
  if (depth == 0) {
    out.push_back({(a + b + c) / 3.0, length(cross(b - a, c - a)) / 2});
    return;
  }
  const Vec3 p = 0.5 * (a + b), q = 0.5 * (b + c), r = 0.5 * (c + a);
  sample_triangle(a, p, r, depth - 1, out);
  sample_triangle(p, b, q, depth - 1, out);
  sample_triangle(r, q, c, depth - 1, out);
  sample_triangle(p, q, r, depth - 1, out);
}

// 16 points a triangle of the fan, spread over the polygon.
std::vector<Sample> samples_of(const Polygon& polygon) {
  std::vector<Sample> out;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sample_triangle(polygon[0], polygon[i - 1], polygon[i], 2, out);
  return out;
}

struct Blocker {
  Polygon polygon;
  Plane plane;
};

bool wholly_in_front(const Polygon& polygon, const Plane& plane, double tolerance) {
  return std::ranges::all_of(polygon,
                             [&](const Vec3& v) { return plane.distance(v) >= -tolerance; });
}

// Could the blocker's plane part the two? If both lie on one side of it, it stands between nothing.
bool may_part(const Blocker& b, const Polygon& p, const Polygon& q, double tolerance) {
  const Plane back = b.plane.flipped();
  return !(wholly_in_front(p, b.plane, tolerance) && wholly_in_front(q, b.plane, tolerance)) &&
         !(wholly_in_front(p, back, tolerance) && wholly_in_front(q, back, tolerance));
}

bool blocks(const Blocker& b, const Vec3& x, const Vec3& y, double tolerance) {
  const double dx = b.plane.distance(x), dy = b.plane.distance(y);
  if (std::min(dx, dy) > -tolerance || std::max(dx, dy) < tolerance) return false;
  return contains(b.polygon, b.plane.normal, x + (y - x) * (dx / (dx - dy)), 0);
}

struct Side {
  const Polygon* polygon;
  Vec3 normal{0};
  std::vector<Sample> samples;
};

// Of the kernel between two elements, the share that no blocker takes.
double seen_share(const Side& p, const Side& q, const std::vector<const Blocker*>& between,
                  double tolerance) {
  double seen = 0, all = 0;
  const std::size_t n = q.samples.size();
  for (std::size_t i = 0; i < p.samples.size(); ++i)
    for (std::size_t k = 0; k < kPartners; ++k) {
      const Sample &a = p.samples[i], &b = q.samples[(i * 7 + k * 11 + i * k) % n];
      const Vec3 d = b.x - a.x;
      const double cosines = dot(p.normal, d) * -dot(q.normal, d);
      if (dot(p.normal, d) <= 0 || cosines <= 0) continue;
      const double g = a.weight * b.weight * cosines / (dot(d, d) * dot(d, d));
      all += g;
      if (std::ranges::none_of(between,
                               [&](const Blocker* x) { return blocks(*x, a.x, b.x, tolerance); }))
        seen += g;
    }
  return all > 0 ? seen / all : 0;
}

std::vector<DenseElement> elements_of(const Scene& scene, const Model& model, double edge) {
  std::vector<DenseElement> elements;
  for (std::size_t p = 0; p < model.patches.size(); ++p) {
    if (model.patches[p].inert) continue;
    const PolygonView outline = model.polygon(model.patches[p]);
    std::vector<Polygon> pieces;
    cut_up(Polygon(outline.begin(), outline.end()), edge, scene.tolerance, pieces);
    for (Polygon& piece : pieces) {
      const double a = area(piece);
      elements.push_back({PatchId(p), std::move(piece), a});
    }
  }
  return elements;
}

double largest(const std::vector<Spectrum>& values) {
  double m = 0;
  for (const Spectrum& v : values) m = std::max({m, v.x, v.y, v.z});
  return m;
}

Spectrum shoot_into(const DenseScene& s, std::size_t i, const std::vector<Spectrum>& b) {
  Spectrum e{0};
  for (std::size_t j = 0; j < s.size(); ++j) e += s.form_factor(i, j) * b[j];
  return s.exitance[i] + s.reflectance[i] * e;
}

double change(const Spectrum& a, const Spectrum& b) {
  return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

}  // namespace

DenseScene make_dense(const Scene& scene, const Model& model, double edge) {
  DenseScene s;
  s.elements = elements_of(scene, model, edge);
  std::vector<Blocker> blockers;
  for (const Patch& p : model.patches) {
    const PolygonView polygon = model.polygon(p);
    blockers.push_back({Polygon(polygon.begin(), polygon.end()), plane_of(polygon)});
  }
  std::vector<Side> sides;
  for (const DenseElement& e : s.elements) {
    const Material& m = scene.materials[model.patches[e.patch.value].material.value];
    s.reflectance.push_back(m.reflectance);
    s.exitance.push_back(m.exitance);
    sides.push_back({&e.polygon, plane_of(e.polygon).normal, samples_of(e.polygon)});
  }
  s.f.assign(s.size() * s.size(), 0);
  const double tolerance = scene.tolerance;
  for (std::size_t i = 0; i < s.size(); ++i)
    for (std::size_t j = i + 1; j < s.size(); ++j) {
      const Side &p = sides[i], &q = sides[j];
      const Result<PolygonFormFactors> whole = polygon_to_polygon(*p.polygon, *q.polygon);
      ATRIUM_CHECK(whole.ok());
      if (!(whole->f12 > 0)) continue;
      std::vector<const Blocker*> between;
      for (const Blocker& b : blockers)
        if (may_part(b, *p.polygon, *q.polygon, tolerance)) between.push_back(&b);
      const double seen = between.empty() ? 1 : seen_share(p, q, between, tolerance);
      s.f[i * s.size() + j] = seen * whole->f12;
      s.f[j * s.size() + i] = seen * whole->f21;
    }
  return s;
}

double row_sum(const DenseScene& scene, std::size_t i) {
  double sum = 0;
  for (std::size_t j = 0; j < scene.size(); ++j) sum += scene.form_factor(i, j);
  return sum;
}

DenseSolution solve_jacobi(const DenseScene& s, double tolerance) {
  DenseSolution solution{s.exitance, 0};
  for (double most = 1; most > tolerance * largest(s.exitance); ++solution.sweeps) {
    std::vector<Spectrum> next(s.size());
    most = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      next[i] = shoot_into(s, i, solution.b);
      most = std::max(most, change(next[i], solution.b[i]));
    }
    solution.b = std::move(next);
  }
  return solution;
}

DenseSolution solve_gauss_seidel(const DenseScene& s, double tolerance) {
  DenseSolution solution{s.exitance, 0};
  for (double most = 1; most > tolerance * largest(s.exitance); ++solution.sweeps) {
    most = 0;
    for (std::size_t i = 0; i < s.size(); ++i) {
      const Spectrum next = shoot_into(s, i, solution.b);
      most = std::max(most, change(next, solution.b[i]));
      solution.b[i] = next;
    }
  }
  return solution;
}

DenseSolution solve_directly(const DenseScene& s) {
  const std::size_t n = s.size();
  DenseSolution solution{s.exitance, 0};
  for (int c = 0; c < 3; ++c) {
    std::vector<double> a(n * n);
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        a[i * n + j] = (i == j) - s.reflectance[i][c] * s.form_factor(i, j);
    for (std::size_t k = 0; k < n; ++k) {
      std::size_t pivot = k;
      for (std::size_t i = k + 1; i < n; ++i)
        if (std::abs(a[i * n + k]) > std::abs(a[pivot * n + k])) pivot = i;
      std::swap(solution.b[k][c], solution.b[pivot][c]);
      for (std::size_t j = k; j < n; ++j) std::swap(a[k * n + j], a[pivot * n + j]);
      for (std::size_t i = k + 1; i < n; ++i) {
        const double factor = a[i * n + k] / a[k * n + k];
        if (factor == 0) continue;
        for (std::size_t j = k; j < n; ++j) a[i * n + j] -= factor * a[k * n + j];
        solution.b[i][c] -= factor * solution.b[k][c];
      }
    }
    for (std::size_t k = n; k-- > 0;) {
      for (std::size_t j = k + 1; j < n; ++j) solution.b[k][c] -= a[k * n + j] * solution.b[j][c];
      solution.b[k][c] /= a[k * n + k];
    }
  }
  return solution;
}

std::vector<Spectrum> patch_irradiance(const DenseScene& s, const DenseSolution& solution,
                                       std::size_t patches) {
  std::vector<Spectrum> light(patches, Spectrum{0});
  std::vector<double> areas(patches, 0);
  for (std::size_t i = 0; i < s.size(); ++i) {
    const std::size_t p = s.elements[i].patch.value;
    Spectrum e{0};
    for (std::size_t j = 0; j < s.size(); ++j) e += s.form_factor(i, j) * solution.b[j];
    light[p] += s.elements[i].area * e;
    areas[p] += s.elements[i].area;
  }
  for (std::size_t p = 0; p < patches; ++p)
    if (areas[p] > 0) light[p] /= areas[p];
  return light;
}

}  // namespace atrium::testing
