// The dense reference: constant elements, all of the form factor matrix, blockers found by trying
// every polygon against every segment. Slow and simple; nothing of tubes, shafts, links, hierarchy
// or the page store is in it.
#pragma once

#include <cstddef>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"

namespace atrium::testing {

struct DenseElement {
  PatchId patch;
  Polygon polygon;
  double area = 0;  // m²
};

struct DenseScene {
  std::vector<DenseElement> elements;
  std::vector<Spectrum> reflectance, exitance;  // an entry an element
  std::vector<double> f;                        // row-major: share of i's light that goes to j
  std::size_t size() const { return elements.size(); }
  double form_factor(std::size_t i, std::size_t j) const { return f[i * size() + j]; }
};

// Uniform elements of at most `edge` metres a side. Form factors are exact where no blocker can
// stand between and by 128 segments a pair elsewhere; rows are left as they are.
DenseScene make_dense(const Scene& scene, const Model& model, double edge);

double row_sum(const DenseScene& scene, std::size_t i);

struct DenseSolution {
  std::vector<Spectrum> b;  // lm/m², an entry an element
  std::size_t sweeps = 0;
};
// ‖change‖∞ below `tolerance` times the largest exitance ends the iterations.
DenseSolution solve_jacobi(const DenseScene& scene, double tolerance);
DenseSolution solve_gauss_seidel(const DenseScene& scene, double tolerance);
DenseSolution solve_directly(const DenseScene& scene);  // elimination with pivots

// Area means of E over each patch of the model, lx; 0 for patches that have no elements.
std::vector<Spectrum> patch_irradiance(const DenseScene& scene, const DenseSolution& solution,
                                       std::size_t patches);

}  // namespace atrium::testing
