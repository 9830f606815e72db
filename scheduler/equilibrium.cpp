#include "scheduler/equilibrium.h"

// The same bits on every machine; and g++ 12 warns of its own AVX-512 headers.
#define EIGEN_DONT_VECTORIZE
#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "scheduler/record_bytes.h"

namespace atrium {

namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Relative residual to which the coarse system is solved, and steps at most: what is left of it is
// left to the sweeps.
constexpr double kSolved = 1e-9;
constexpr int kMostSteps = 500;
// Where a sweep changes so many times as much as the one before it, the corrections reach too far.
constexpr double kGrows = 8, kLessReach = 8;
// Bounces over which a measured gain is followed: it has noise, which must not grow without bound.
constexpr double kGainsReach = 16;
// Sweeps whose steps are mixed.
constexpr std::size_t kDepth = 6;

struct Head {
  std::uint32_t units = 0, steps = 0;
  double reach = 0, last_change = 0;
};

double cluster_area(const Model& model, const Cluster& c) {
  double sum = 0;
  for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
    sum += area(model.polygon(model.patches[p]));
  return sum;
}

}  // namespace

Equilibrium::Equilibrium(const Model& model, std::span<const ClusterId> order)
    : unit_of_patch_(model.patches.size()) {
  std::vector<std::uint32_t> place(model.clusters.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i].value] = std::uint32_t(i);
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    const Cluster& cluster = model.clusters[c];
    const double least = kLargeShare * cluster_area(model, cluster);
    first_patch_.push_back(cluster.first_patch);
    first_unit_.push_back(std::uint32_t(area_.size()));
    area_.push_back(0);  // of the rest
    for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p) {
      const double own = area(model.polygon(model.patches[p]));
      if (own >= least) area_.push_back(0);
      const std::uint32_t unit = own >= least ? std::uint32_t(area_.size() - 1) : first_unit_[c];
      unit_of_patch_[p] = unit;
      area_[unit] += own;
    }
    rank_.resize(area_.size(), place[c]);
  }
  first_patch_.push_back(std::uint32_t(model.patches.size()));
  first_unit_.push_back(std::uint32_t(area_.size()));
  k_.resize(units());
  change_.assign(units(), Spectrum{0});
  mean_.assign(units(), Spectrum{0});
  pending_.assign(units(), Spectrum{0});
}

std::span<const std::uint32_t> Equilibrium::units_of(ClusterId cluster) const {
  const std::uint32_t first = first_patch_[cluster.value];
  return std::span(unit_of_patch_).subspan(first, first_patch_[cluster.value + 1] - first);
}

std::vector<Spectrum> Equilibrium::pending(ClusterId cluster) const {
  std::vector<Spectrum> light;
  for (const std::uint32_t u : units_of(cluster)) light.push_back(pending_[u]);
  return light;
}

void Equilibrium::gathered(ClusterId receiver, std::span<const Spectrum> gained,
                           std::span<const Spectrum> light) {
  const std::span<const std::uint32_t> units = units_of(receiver);
  for (const std::uint32_t u : units) change_[u] = pending_[u] = Spectrum{0};
  for (const std::uint32_t u : units) mean_[u] = Spectrum{0};
  for (std::size_t p = 0; p < units.size(); ++p) {
    change_[units[p]] += gained[p] / area_[units[p]];
    mean_[units[p]] += light[p] / area_[units[p]];
  }
}

void Equilibrium::set_rows(const CoarseRows& rows) {
  for (std::size_t i = 0; i < rows.rows_.size(); ++i) {
    const std::size_t u = rows.first_ + i;
    const double kept = rows.linked_[i] > 0 ? 1 - rows.too_much_[i] / rows.linked_[i] : 1;
    const double made_up = rows.doubt_[i] > 0 ? rows.missing_[i] / rows.doubt_[i] : 0;
    std::vector<CoarseEntry> row = rows.rows_[i];
    for (CoarseEntry& e : row)
      for (int c = 0; c < kChannels; ++c)
        e.share[c] = float((kept * e.share[c] + made_up * e.doubt[c]) / area_[u]);
    set_row(std::uint32_t(u), std::move(row));
  }
}

// (I - K) x = r for one channel.
void Equilibrium::solve_channel(int channel, double reach, std::span<const Spectrum> residual,
                                std::span<Spectrum> x) const {
  const auto n = Eigen::Index(units());
  const double damping = 1 - 1 / reach;
  SparseRows a(n, n);
  Eigen::VectorXi sizes(n);
  for (Eigen::Index u = 0; u < n; ++u) sizes[u] = int(k_[u].size()) + 1;
  a.reserve(sizes);
  Eigen::VectorXd b(n);
  for (Eigen::Index u = 0; u < n; ++u) {
    a.insert(u, u) = 1;
    b[u] = residual[u][channel];
    for (const CoarseEntry& e : k_[u]) a.coeffRef(u, e.unit) -= damping * e.share[channel];
  }
  a.makeCompressed();
  Eigen::BiCGSTAB<SparseRows, Eigen::DiagonalPreconditioner<double>> solver;
  solver.setTolerance(kSolved);
  solver.setMaxIterations(kMostSteps);
  solver.compute(a);
  const Eigen::VectorXd found = solver.solve(b);
  for (Eigen::Index u = 0; u < n; ++u) x[u][channel] = found[u];
}

// x, of the last step's `from`, by Anderson's acceleration. [Walker & Ni 2011]
void Equilibrium::accelerate(int channel, std::span<Spectrum> next) const {
  const auto n = Eigen::Index(units());
  const auto m = Eigen::Index(steps_.size()) - 1;
  const Step& last = steps_.back();
  Eigen::VectorXd f(n);
  Eigen::MatrixXd df(n, m), dx(n, m);
  for (Eigen::Index u = 0; u < n; ++u) {
    const double w = std::sqrt(area_[u]);
    f[u] = w * last.by[u][channel];
    for (Eigen::Index j = 0; j < m; ++j) {
      df(u, j) = w * (steps_[j + 1].by[u][channel] - steps_[j].by[u][channel]);
      dx(u, j) = w * (steps_[j + 1].from[u][channel] - steps_[j].from[u][channel]);
    }
  }
  Eigen::VectorXd mix = Eigen::VectorXd::Zero(m);
  if (m > 0) mix = df.colPivHouseholderQr().solve(f);
  const Eigen::VectorXd x = f - (dx + df) * mix;
  for (Eigen::Index u = 0; u < n; ++u)
    next[u][channel] = last.from[u][channel] + x[u] / std::sqrt(area_[u]);
}

void Equilibrium::forget() {
  steps_.clear();
  last_change_ = 0;
}

void Equilibrium::correct(double change) {
  if (last_change_ > 0 && !(change < kGrows * last_change_)) {
    reach_ = std::max(1.0, reach_ / kLessReach);
    steps_.clear();
  }
  last_change_ = change;
  std::vector<Spectrum> residual(units(), Spectrum{0});
  for (std::size_t u = 0; u < units(); ++u)
    for (const CoarseEntry& e : k_[u])
      if (rank_[e.unit] >= rank_[u])
        residual[u] += Spectrum{e.share[0], e.share[1], e.share[2]} * change_[e.unit];
  std::vector<Spectrum> x(units(), Spectrum{0});
  for (int c = 0; c < kChannels; ++c) solve_channel(c, reach_, residual, x);
  Step step{std::vector<Spectrum>(units()), std::vector<Spectrum>(units())};
  for (std::size_t u = 0; u < units(); ++u) {
    step.from[u] = mean_[u] - change_[u];
    step.by[u] = change_[u] + x[u];
  }
  steps_.push_back(std::move(step));
  if (steps_.size() > kDepth + 1) steps_.erase(steps_.begin());
  for (int c = 0; c < kChannels; ++c) accelerate(c, x);
  for (std::size_t u = 0; u < units(); ++u) pending_[u] = x[u] - mean_[u];
}

void Equilibrium::spread_gains() {
  std::vector<Spectrum> x(units(), Spectrum{0});
  for (int c = 0; c < kChannels; ++c) solve_channel(c, kGainsReach, change_, x);
  for (std::size_t u = 0; u < units(); ++u) pending_[u] = x[u] - change_[u];
}

// Little endian, as in memory: Head, sizes of the rows, their entries, then by unit the mean, the
// change and what is pending, then each step's two vectors.
std::vector<std::byte> Equilibrium::saved() const {
  RecordOut out;
  const Head head{std::uint32_t(units()), std::uint32_t(steps_.size()), reach_, last_change_};
  out.put(std::span(&head, 1));
  std::vector<std::uint32_t> sizes;
  for (const auto& row : k_) sizes.push_back(std::uint32_t(row.size()));
  out.put(std::span<const std::uint32_t>(sizes));
  for (const auto& row : k_) out.put(std::span<const CoarseEntry>(row));
  for (const auto* light : {&mean_, &change_, &pending_}) out.put(std::span<const Spectrum>(*light));
  for (const Step& step : steps_) {
    out.put(std::span<const Spectrum>(step.from));
    out.put(std::span<const Spectrum>(step.by));
  }
  return out.take();
}

Status Equilibrium::restore(std::span<const std::byte> record) {
  RecordIn in(record);
  const Status broken(Code::kStore, "", "equilibrium record",
                      "its length is not what it says it holds", "run atrium check on the run");
  std::vector<Head> head;
  std::vector<std::uint32_t> sizes;
  if (!in.get(head, 1) || head[0].units != units() || !in.get(sizes, units())) return broken;
  for (std::size_t u = 0; u < units(); ++u)
    if (!in.get(k_[u], sizes[u])) return broken;
  for (auto* light : {&mean_, &change_, &pending_})
    if (!in.get(*light, units())) return broken;
  steps_.resize(std::min<std::size_t>(head[0].steps, kDepth + 1));
  for (Step& step : steps_)
    if (!in.get(step.from, units()) || !in.get(step.by, units())) return broken;
  if (!in.empty()) return broken;
  reach_ = head[0].reach;
  last_change_ = head[0].last_change;
  return {};
}

CoarseRows::CoarseRows(const Equilibrium& equilibrium, ClusterId receiver)
    : equilibrium_(equilibrium),
      receiver_(receiver),
      first_(equilibrium.first_unit_[receiver.value]) {
  const std::size_t n = equilibrium.first_unit_[receiver.value + 1] - first_;
  rows_.resize(n);
  doubt_.resize(n);
  linked_.resize(n);
  missing_.resize(n);
  too_much_.resize(n);
}

void CoarseRows::add(const Braid& braid, const ClusterView& source,
                     std::span<const PatchTree> receiver, const GroupView& groups) {
  const std::span<const std::uint32_t> to = equilibrium_.units_of(receiver_);
  const std::span<const std::uint32_t> from = equilibrium_.units_of(braid.source);
  const std::uint32_t first = equilibrium_.first_unit_[braid.source.value];
  const std::size_t width = equilibrium_.first_unit_[braid.source.value + 1] - first;
  std::vector<CoarseEntry> block(rows_.size() * width);
  // A group is of the unit that its patches are of.
  const auto row_of = [&](const Braid::Strand& s) -> std::size_t {
    if (s.patch < to.size()) return to[s.patch] - first_;
    return to[groups.any_patch(groups.groups[s.patch - to.size()])] - first_;
  };
  const auto entry = [&](const Braid::Strand& s, std::uint32_t source_patch) -> CoarseEntry& {
    const GroupView of = source.groups();
    const std::uint32_t patch = source_patch < from.size()
                                    ? source_patch
                                    : of.any_patch(of.groups[source_patch - from.size()]);
    return block[row_of(s) * width + from[patch] - first];
  };
  const auto area_of = [&](const Braid::Strand& s, const LinkHead& link) {
    return s.patch < to.size() ? receiver[s.patch].elements[link.receiver].area
                               : groups.groups[s.patch - to.size()].area;
  };
  const auto reflectance_of = [&](std::uint32_t source_patch) -> const Spectrum& {
    return source_patch < from.size() ? source.patch_head(source_patch).reflectance
                                      : source.groups().groups[source_patch - from.size()].reflectance;
  };
  const auto put = [&](const Braid::Strand& s, const LinkHead& link, double coupling) {
    const double f = coupling * area_of(s, link);
    const Spectrum& rho = reflectance_of(link.source_patch);
    CoarseEntry& e = entry(s, link.source_patch);
    for (int c = 0; c < kChannels; ++c) e.share[c] += float(f * rho[c]);
    linked_[row_of(s)] += f;
  };
  const int order = receiver.front().order;
  const std::size_t k2 = std::size_t(coefficient_count(order)) * coefficient_count(order);
  for (const Braid::Strand& s : braid.strands) {
    for (std::size_t i = s.first_link; i < s.first_link + s.links; ++i)
      put(s, braid.links[i], braid.couplings[i * k2]);
    for (const ThinLink& t : std::span(braid.thin).subspan(s.first_thin, s.thin))
      put(s, t.ends, t.coupling);
    for (const Doubt& d : std::span(braid.doubts).subspan(s.first_doubt, s.doubts)) {
      const Spectrum& rho = reflectance_of(d.source_patch);
      CoarseEntry& e = entry(s, d.source_patch);
      for (int c = 0; c < kChannels; ++c) e.doubt[c] += float(d.weight * rho[c]);
      doubt_[row_of(s)] += d.weight;
    }
  }
  for (std::size_t u = 0; u < rows_.size(); ++u)
    for (std::size_t v = 0; v < width; ++v) {
      CoarseEntry e = block[u * width + v];
      e.unit = std::uint32_t(first + v);
      if (e.share != std::array<float, kChannels>{} || e.doubt != std::array<float, kChannels>{})
        rows_[u].push_back(e);
    }
}

void CoarseRows::close(std::size_t patch, const PatchTree& tree, const Closing& closing) {
  const std::size_t u = equilibrium_.units_of(receiver_)[patch] - first_;
  if (closing.how == Closing::How::kNoMore)
    too_much_[u] -= closing.missing * tree.head.area;
  else if (closing.how != Closing::How::kOpen)
    missing_[u] += closing.missing * tree.head.area;
}

}  // namespace atrium
