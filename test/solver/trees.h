// Patches by hand for tests of the solver: planar polygons in space, planted as element trees, and
// the record of a cluster that holds them. Beside them a quadrature of its own, by collapsed
// Gauss-Legendre over a fan of triangles, that owes nothing to solver/basis.h.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/model.h"
#include "engine/scene.h"
#include "solver/basis.h"
#include "solver/element_tree.h"

namespace atrium::testing {

struct Paint {
  Spectrum reflectance{0};
  Spectrum exitance{0};
};

// A model of one cluster.
class Patches {
 public:
  explicit Patches(int order = 2) : order_(order) {
    model_.clusters.push_back({});
    model_.tolerance = 1e-6;
  }

  PatchId add(PolygonView polygon, const Paint& paint = {},
              std::span<const Contact> contacts = {}) {
    Patch p;
    p.material = MaterialId(scene_.materials.size());
    p.cluster = ClusterId(0u);
    p.first_vertex = static_cast<std::uint32_t>(model_.vertices.size());
    p.vertex_count = static_cast<std::uint32_t>(polygon.size());
    scene_.materials.push_back({"paint", paint.reflectance, paint.exitance});
    model_.vertices.insert(model_.vertices.end(), polygon.begin(), polygon.end());
    model_.patches.push_back(p);
    model_.contacts.push_row(contacts);
    return PatchId(model_.patches.size() - 1);
  }

  PatchTree tree(PatchId patch) const { return plant(model_, scene_, patch, order_); }
  std::vector<PatchTree> trees() const {
    std::vector<PatchTree> all;
    for (std::size_t p = 0; p < model_.patches.size(); ++p) all.push_back(tree(PatchId(p)));
    return all;
  }
  PolygonView polygon(PatchId patch) const { return model_.polygon(model_.patches[patch.value]); }

 private:
  int order_;
  Model model_;
  Scene scene_;
};

// The bytes of a record and the view of them.
class Record {
 public:
  Record(std::uint32_t cluster, std::span<PatchTree> trees) : bytes_(record_bytes(trees)) {
    write_record(cluster, trees, bytes_);
  }
  ClusterView view() const { return ClusterView::parse(bytes_).value(); }
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

inline Polygon in_plane(std::span<const Vec2> outline) {
  Polygon p;
  for (const Vec2& v : outline) p.push_back({v.x, v.y, 0});
  return p;
}

// The rectangle from `corner` along two edges; its normal is cross(a, b).
inline Polygon parallelogram(const Vec3& corner, const Vec3& a, const Vec3& b) {
  return {corner, corner + a, corner + a + b, corner + b};
}

// ∫ f dA over a convex polygon in the plane: a fan of triangles, each cut into 4^depth, 25 Gauss
// nodes in each: exact for polynomials up to degree 8.
template <class F>
double integrate_triangle(const Vec2& a, const Vec2& b, const Vec2& c, int depth, const F& f) {
  if (depth > 0) {
    const Vec2 p = 0.5 * (a + b), q = 0.5 * (b + c), r = 0.5 * (c + a);
    return integrate_triangle(a, p, r, depth - 1, f) + integrate_triangle(p, b, q, depth - 1, f) +
           integrate_triangle(r, q, c, depth - 1, f) + integrate_triangle(p, q, r, depth - 1, f);
  }
  constexpr double kAt[] = {0.04691007703066800360, 0.23076534494715845448, 0.5,
                            0.76923465505284154552, 0.95308992296933199640};
  constexpr double kWeight[] = {0.11846344252809454376, 0.23931433524968323402, 64.0 / 225,
                                0.23931433524968323402, 0.11846344252809454376};
  const Vec2 ab = b - a, bc = c - b;
  const double jacobian = ab.x * bc.y - ab.y * bc.x;  // twice the area
  double sum = 0;
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      sum += kWeight[i] * kWeight[j] * kAt[i] * f(a + kAt[i] * (ab + kAt[j] * bc));
  return sum * jacobian;
}
template <class F>
double integrate(std::span<const Vec2> polygon, int depth, const F& f) {
  double sum = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    sum += integrate_triangle(polygon[0], polygon[i - 1], polygon[i], depth, f);
  return sum;
}

inline double area2(std::span<const Vec2> polygon) {
  return integrate(polygon, 0, [](const Vec2&) { return 1.0; });
}

inline bool inside(std::span<const Vec2> polygon, const Vec2& p, double tolerance) {
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec2 a = polygon[i], d = polygon[(i + 1) % polygon.size()] - a, q = p - a;
    if (d.x * q.y - d.y * q.x < -tolerance * std::hypot(d.x, d.y)) return false;
  }
  return true;
}

// A random point of a convex polygon: a random mixture of its corners.
inline Vec2 point_of(std::span<const Vec2> polygon, std::mt19937& dice) {
  std::exponential_distribution<double> weight;
  Vec2 p{0};
  double sum = 0;
  for (const Vec2& v : polygon) {
    const double w = weight(dice);
    p += w * v;
    sum += w;
  }
  return p / sum;
}

// E of element i at p (patch frame), channel c.
inline double value_at(const PatchTree& tree, std::size_t i, const Vec2& p, int c) {
  const PatchView v = tree.view();
  const BasisValues phi = evaluate_basis(v.basis_of(i), tree.elements[i], tree.order, p);
  double sum = 0;
  for (int a = 0; a < v.k(); ++a) sum += phi[a] * v.e_of(i)[a * kChannels + c];
  return sum;
}

// Splits leaves, front to back, until the tree has `elements` or none can be split.
inline void grow(PatchTree& tree, std::size_t elements, double min_edge = 0) {
  for (std::size_t i = 0; i < tree.elements.size() && tree.elements.size() < elements; ++i)
    if (tree.elements[i].leaf()) split_leaf(tree, static_cast<std::int32_t>(i), min_edge);
}

}  // namespace atrium::testing
