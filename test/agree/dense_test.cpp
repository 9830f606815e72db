// The partitioned out-of-core solver against a dense matrix, in every order. "The scheduler is
// performing Gauss-Seidel iteration of the linear system ... convergence of the partitioning
// algorithm is assured." [THFH94 §5.2]
#include "test/agree/dense.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>

#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "test/agree/scenes.h"

namespace atrium::testing {
namespace {

constexpr double kCoarseEdge = 1.6, kFineEdge = 0.8;  // m, of the dense elements

struct Reference {
  Prepared prepared;
  DenseScene coarse, fine;
  std::vector<Spectrum> e_coarse, e_fine;  // means over patches, lx
};

Reference make_reference(Bench& bench) {
  Result<Prepared> p = prepare(bench.options());
  EXPECT_TRUE(p.ok()) << p.status().message();
  Reference r{std::move(p).value(), {}, {}, {}, {}};
  const std::size_t patches = r.prepared.model.patches.size();
  r.coarse = make_dense(r.prepared.scene, r.prepared.model, kCoarseEdge);
  r.fine = make_dense(r.prepared.scene, r.prepared.model, kFineEdge);
  r.e_coarse = patch_irradiance(r.coarse, solve_gauss_seidel(r.coarse, 1e-9), patches);
  r.e_fine = patch_irradiance(r.fine, solve_gauss_seidel(r.fine, 1e-9), patches);
  return r;
}

struct Subject {
  Bench bench;
  Reference reference;
  explicit Subject(const GeneratedModel& model) : bench(model), reference(make_reference(bench)) {}
};

// Means of E over patches, from the roots of their trees.
std::vector<Spectrum> patch_irradiance(SolvedRun& run, std::size_t patches) {
  std::vector<Spectrum> e(patches, Spectrum{0});
  const Status s = run.solution().for_each_cluster([&](ClusterId, const ClusterView& view) {
    for (std::size_t p = 0; p < view.size(); ++p) {
      const std::span<const double> root = view.patch(p).e_of(0);
      e[view.patch_head(p).patch] = {root[0], root[1], root[2]};
    }
  });
  EXPECT_TRUE(s.ok()) << s.message();
  return e;
}

// Root mean square over area of the difference between patch means, each relative to the larger of
// E there and E's mean, in luminance: the error of the command line's contract.
double difference(const Model& model, const std::vector<Spectrum>& e,
                  const std::vector<Spectrum>& truth) {
  double mean = 0, whole = 0;
  for (std::size_t p = 0; p < truth.size(); ++p) {
    const double a = model.patches[p].inert ? 0 : area(model.polygon(model.patches[p]));
    mean += a * luminance(truth[p]);
    whole += a;
  }
  mean /= whole;
  double sum2 = 0;
  for (std::size_t p = 0; p < truth.size(); ++p) {
    if (model.patches[p].inert) continue;
    const double t = luminance(truth[p]), d = (luminance(e[p]) - t) / std::max(t, mean);
    sum2 += area(model.polygon(model.patches[p])) * d * d;
  }
  return std::sqrt(sum2 / whole);
}

// Either scene with its reference, made when it is first asked for.
class Dense : public ::testing::TestWithParam<std::size_t> {
 protected:
  static void TearDownTestSuite() { subjects_ = {}; }
  Subject& subject() {
    std::unique_ptr<Subject>& s = subjects_[GetParam()];
    if (!s) s = std::make_unique<Subject>(GetParam() == 0 ? cornell_model() : two_rooms_model());
    return *s;
  }
  Bench& bench() { return subject().bench; }
  const Reference& reference() { return subject().reference; }

 private:
  static inline std::array<std::unique_ptr<Subject>, 2> subjects_;
};

TEST_P(Dense, RowsOfAClosedSceneSumToOneOrLess) {
  const DenseScene& fine = reference().fine;
  ASSERT_GT(fine.size(), 200u);
  double mean = 0, whole = 0;
  for (std::size_t i = 0; i < fine.size(); ++i) {
    EXPECT_LT(row_sum(fine, i), 1.05);
    mean += fine.elements[i].area * row_sum(fine, i);
    whole += fine.elements[i].area;
  }
  // What stands on the floor hides up to a thirtieth of all area from all.
  EXPECT_GT(mean / whole, 0.96);
}

TEST_P(Dense, JacobiGaussSeidelAndEliminationAgree) {
  const DenseScene& fine = reference().fine;
  const DenseSolution jacobi = solve_jacobi(fine, 1e-13);
  const DenseSolution seidel = solve_gauss_seidel(fine, 1e-13);
  const DenseSolution direct = solve_directly(fine);
  double most = 0;
  for (const Spectrum& b : direct.b) most = std::max({most, b.x, b.y, b.z});
  for (std::size_t i = 0; i < fine.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(jacobi.b[i][c], direct.b[i][c], 1e-10 * most);
      EXPECT_NEAR(seidel.b[i][c], direct.b[i][c], 1e-10 * most);
    }
  EXPECT_LT(seidel.sweeps, jacobi.sweeps);
}

// Against the dense reference: its own discretisation, which is what halving its elements changes,
// and the error asked for. Orders among each other: each leaves a fiftieth of that error undone,
// and takes its decisions of refinement on a brightness that is not yet the other's: where one
// splits an element and the other does not, constants differ by half a step, linear functions by
// less.
TEST_P(Dense, PartitionedSolverAgreesInEveryOrder) {
  const Reference& r = reference();
  const Model& model = r.prepared.model;
  const double discretisation = difference(model, r.e_coarse, r.e_fine);
  ASSERT_LT(discretisation, 0.01);
  for (const int basis : {1, 2, 3}) {
    std::vector<std::vector<Spectrum>> solutions;
    const double error = basis == 1 ? 0.04 : 0.01;
    const double among_orders = error / (basis == 1 ? 5 : 10);
    for (const std::string& order : order_names()) {
      SCOPED_TRACE(order + ", basis " + std::to_string(basis));
      SolveOptions o = bench().options();
      o.order = order;
      o.basis = basis;
      o.error = error;
      o.residual = 1e-5;  // to the last level: an estimate may take one order's coarser answer
      SolvedRun run(o);
      ASSERT_TRUE(run.ok());
      EXPECT_EQ(run.summary().exit_code, 0);
      solutions.push_back(patch_irradiance(run, model.patches.size()));
      EXPECT_LT(difference(model, solutions.back(), r.e_fine), discretisation + error);
      EXPECT_LT(difference(model, solutions.back(), solutions[0]), among_orders);
    }
  }
}

std::string scene_name(const ::testing::TestParamInfo<std::size_t>& scene) {
  return scene.param == 0 ? "Cornell" : "TwoRooms";
}
INSTANTIATE_TEST_SUITE_P(Scenes, Dense, ::testing::Values(0u, 1u), scene_name);

}  // namespace
}  // namespace atrium::testing
