#include "scheduler/coarse_solve.h"

// The same bits on every machine; and g++ 12 warns of its own AVX-512 headers.
#define EIGEN_DONT_VECTORIZE
#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

#include "engine/squared.h"

namespace atrium {

namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Relative residual to which the undivided system is solved, and steps at most.
constexpr double kSolved = 1e-9;
constexpr int kMostSteps = 500;
// Share of r that may be left of it, and cycles at most: sweeps leave as much.
constexpr double kLeft = 0.2;
constexpr std::size_t kMostCycles = 8;

using Channel = std::vector<double>;  // by unit

// K of undivided patches, by the areas of their parts; the places are laid down once for all
// channels.
class UndividedSystem {
 public:
  UndividedSystem(const CoarseUnits& units, const CoarseMatrix& k, double damping)
      : units_(units), k_(k), damping_(damping), number_(undivided_numbers(units)) {
    area_.resize(number_.empty() ? 0 : number_.back() + 1);
    sums_.resize(area_.size());
    for (std::size_t u = 0; u < units.size(); ++u) area_[number_[u]] += units.areas()[u];
    lay_down();
  }

  bool is_all() const { return area_.size() == units_.size(); }

  // From here on it is this channel's.
  void fill(int channel) {
    std::size_t u = 0;
    for (std::uint32_t row = 0; row < area_.size(); ++row) {
      for (; u < units_.size() && number_[u] == row; ++u) {
        const double part = share(u);
        for (const CoarseEntry& e : k_[u])
          sums_[number_[e.unit]] += part * double(e.share[std::size_t(channel)]);
      }
      for (int at = a_.outerIndexPtr()[row]; at < a_.outerIndexPtr()[row + 1]; ++at) {
        const int column = a_.innerIndexPtr()[at];
        double& sum = sums_[std::size_t(column)];
        a_.valuePtr()[at] = (column == int(row) ? 1 : 0) - damping_ * sum;
        sum = 0;
      }
    }
    solver_.setTolerance(kSolved);
    solver_.setMaxIterations(kMostSteps);
    solver_.compute(a_);
  }

  // Adds to x what undivided patches make of the mean of r over each.
  void add_solution(const Channel& r, Channel& x) const {
    Eigen::VectorXd means = Eigen::VectorXd::Zero(a_.rows());
    for (std::size_t u = 0; u < r.size(); ++u) means[number_[u]] += share(u) * r[u];
    const Eigen::VectorXd found = solver_.solve(means);
    for (std::size_t u = 0; u < x.size(); ++u) x[u] += found[number_[u]];
  }

 private:
  // Of its patch's area.
  double share(std::size_t unit) const {
    return units_.divided(unit) ? units_.areas()[unit] / area_[number_[unit]] : 1;
  }

  // The 1 of I beside what K has there.
  void lay_down() {
    const auto n = Eigen::Index(area_.size());
    std::vector<std::uint32_t> last(area_.size(), ~std::uint32_t{0});  // row that has it
    std::vector<int> columns, begins;
    std::size_t u = 0;
    for (std::uint32_t row = 0; row < area_.size(); ++row) {
      begins.push_back(int(columns.size()));
      columns.push_back(int(row));
      last[row] = row;
      for (; u < units_.size() && number_[u] == row; ++u)
        for (const CoarseEntry& e : k_[u]) {
          const std::uint32_t column = number_[e.unit];
          if (last[column] == row) continue;
          last[column] = row;
          columns.push_back(int(column));
        }
      std::sort(columns.begin() + begins.back(), columns.end());
    }
    begins.push_back(int(columns.size()));
    a_.resize(n, n);
    a_.resizeNonZeros(Eigen::Index(columns.size()));
    std::ranges::copy(begins, a_.outerIndexPtr());
    std::ranges::copy(columns, a_.innerIndexPtr());
  }

  const CoarseUnits& units_;
  const CoarseMatrix& k_;
  double damping_;
  std::vector<std::uint32_t> number_;  // by unit
  std::vector<double> area_;           // m², by patch
  std::vector<double> sums_;           // of a row, by patch
  SparseRows a_;
  Eigen::BiCGSTAB<SparseRows, Eigen::DiagonalPreconditioner<double>> solver_;
};

double product(const Channel& a, const Channel& b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

void add(double by, const Channel& more, Channel& to) {
  for (std::size_t u = 0; u < to.size(); ++u) to[u] += by * more[u];
}

// I - K of one channel, damped, over all units.
class Operator {
 public:
  Operator(const CoarseMatrix& k, int channel, double damping)
      : k_(k), channel_(std::size_t(channel)), damping_(damping) {}

  Channel times(const Channel& x) const {
    Channel out(x.size());
    for (std::size_t u = 0; u < x.size(); ++u) out[u] = x[u] - arriving(u, x);
    return out;
  }
  // One step of Gauss and Seidel's from nothing, in the units' order.
  Channel step(const Channel& r) const {
    Channel x(r.size(), 0);
    for (std::size_t u = 0; u < x.size(); ++u) x[u] = r[u] + arriving(u, x);
    return x;
  }

 private:
  double arriving(std::size_t unit, const Channel& x) const {
    double sum = 0;
    for (const CoarseEntry& e : k_[unit]) sum += e.share[channel_] * x[e.unit];
    return damping_ * sum;
  }

  const CoarseMatrix& k_;
  const std::size_t channel_;
  const double damping_;
};

// Where a direction leads, and what it makes of the residual, by its square.
struct Direction {
  Channel x, change;
  double square = 0;
};

// x of r: over undivided patches at once, then in cycles of two grids, each taken as far as it
// makes the residual less, and none undoing what those before it did. What is left has no mean over
// any patch.
Channel solve_channel(const UndividedSystem& undivided, const Operator& a, const Channel& r) {
  Channel x(r.size(), 0);
  undivided.add_solution(r, x);
  if (undivided.is_all()) return x;
  Channel left = r;
  add(-1, a.times(x), left);
  const double enough = squared(kLeft) * product(r, r);
  std::vector<Direction> gone;
  while (gone.size() < kMostCycles && product(left, left) > enough) {
    Direction next{a.step(left), {}};
    Channel still = left;
    add(-1, a.times(next.x), still);
    undivided.add_solution(still, next.x);
    next.change = a.times(next.x);
    for (const Direction& before : gone) {
      const double along = product(next.change, before.change) / before.square;
      add(-along, before.x, next.x);
      add(-along, before.change, next.change);
    }
    next.square = product(next.change, next.change);
    if (!(next.square > 0)) break;
    const double far = product(left, next.change) / next.square;
    add(far, next.x, x);
    add(-far, next.change, left);
    gone.push_back(std::move(next));
  }
  return x;
}

}  // namespace

std::vector<std::uint32_t> undivided_numbers(const CoarseUnits& units) {
  std::vector<std::uint32_t> numbers(units.size());
  for (std::size_t u = 1; u < units.size(); ++u)
    numbers[u] = numbers[u - 1] + (units.first_part(u) == u);
  return numbers;
}

std::vector<Spectrum> solve_coarse(const CoarseUnits& units, const CoarseMatrix& k, double damping,
                                   std::span<const Spectrum> light) {
  UndividedSystem undivided(units, k, damping);
  std::vector<Spectrum> found(units.size());
  for (int c = 0; c < kChannels; ++c) {
    undivided.fill(c);
    Channel r;
    for (const Spectrum& s : light) r.push_back(s[c]);
    const Channel x = solve_channel(undivided, Operator(k, c, damping), r);
    for (std::size_t u = 0; u < x.size(); ++u) found[u][c] = x[u];
  }
  return found;
}

}  // namespace atrium
