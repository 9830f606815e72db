#include "scheduler/equilibrium.h"

// The same bits on every machine; and g++ 12 warns of its own AVX-512 headers.
#define EIGEN_DONT_VECTORIZE
#include <Eigen/Dense>
#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "scheduler/record_pieces.h"

namespace atrium {

namespace {

using SparseRows = Eigen::SparseMatrix<double, Eigen::RowMajor>;

// Relative residual to which the coarse system is solved, and steps at most: what is left of it is
// left to the sweeps.
constexpr double kSolved = 1e-9;
constexpr int kMostSteps = 500;
// Bounces that a correction looks ahead: as many as paint of ρ = .99999 asks for and a hundred
// times more, so that white rooms find their level at once. Where a sweep changes so many times as
// much as the one before it that was too far.
constexpr double kFarthest = 1e7;
constexpr double kGrows = 8, kLessReach = 8;
// Bounces over which a measured gain is followed: it has noise, which must not grow without bound.
constexpr double kGainsReach = 16;
// Where a gather takes back more than this share of its unit's correction, and changes it more than
// this many times what the last did, the unit's mean does not tell what its patches see: the next
// correction is taken in part. One that holds is trusted again, more slowly.
constexpr double kTakenBack = 0.5, kSettles = 0.9;
constexpr double kLessTrust = 0.5, kMoreTrust = 1.5, kLeastTrust = 1.0 / 64;
static_assert(kLessTrust * kMoreTrust < 1);

// Sweeps of a level from which shares of detail are learnt: then light is about where it stays, and
// shares that went on with it would keep it from settling.
constexpr std::uint64_t kLearning = 4;
// Of what a unit sends, how much its detail may add elsewhere. Where more is missed it is form
// factors that are off.
constexpr double kMostMissed = 0.005;

Spectrum share_of(const CoarseEntry& e) { return {e.share[0], e.share[1], e.share[2]}; }

struct Head {
  std::uint64_t units = 0, sweeps = 0;
  double reach = 0, last_change = 0;
};

Status of_other_units(RecordKind kind) {
  return Status(Code::kStore, "", to_string(record_id(kind, 0)), "it is not of this model's units",
                "run atrium check on the run");
}

// m², of what takes part in the exchange of light.
double lit_area(const Model& model, std::uint32_t patch) {
  return model.patches[patch].inert ? 0 : area(model.polygon(model.patches[patch]));
}

double lit_area(const Model& model, const Cluster& c) {
  double sum = 0;
  for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
    sum += lit_area(model, p);
  return sum;
}

}  // namespace

Equilibrium::Equilibrium(const Model& model, std::span<const ClusterId> order)
    : unit_of_patch_(model.patches.size()), reach_(kFarthest) {
  std::vector<std::uint32_t> place(model.clusters.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i].value] = std::uint32_t(i);
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    const Cluster& cluster = model.clusters[c];
    const double least = kLargeShare * lit_area(model, cluster);
    first_patch_.push_back(cluster.first_patch);
    first_unit_.push_back(std::uint32_t(area_.size()));
    area_.push_back(0);  // of the rest
    for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count;
         ++p) {
      const double own = lit_area(model, p);
      const bool apart = own > 0 && own >= least;
      if (apart) area_.push_back(0);
      const std::uint32_t unit = apart ? std::uint32_t(area_.size() - 1) : first_unit_[c];
      unit_of_patch_[p] = unit;
      area_[unit] += own;
    }
    rank_.resize(area_.size(), place[c]);
    cluster_of_unit_.resize(area_.size(), std::uint32_t(c));
  }
  first_patch_.push_back(std::uint32_t(model.patches.size()));
  first_unit_.push_back(std::uint32_t(area_.size()));
  k_.resize(units());
  change_.assign(units(), Spectrum{0});
  beyond_.assign(units(), Spectrum{0});
  pending_.assign(units(), Spectrum{0});
  trust_.assign(units(), 1);
  for (auto* sums : {&missed_, &sent_, &left_out_, &detail_share_}) sums->assign(units(), 0);
  reached_.assign(model.clusters.size(), Reached::kNow);
  for (auto* light : {&owed_, &came_}) light->assign(units(), Spectrum{0});
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

std::vector<std::uint32_t> Equilibrium::by_unit(ClusterId cluster) const {
  const std::span<const std::uint32_t> units = units_of(cluster);
  std::vector<std::uint32_t> patches(units.size());
  std::iota(patches.begin(), patches.end(), 0u);
  std::ranges::stable_sort(patches, {}, [&](std::uint32_t p) { return units[p]; });
  return patches;
}

void Equilibrium::gathered(ClusterId receiver, std::span<const PatchGain> patches) {
  const std::uint32_t first = first_unit_[receiver.value];
  const std::size_t count = first_unit_[receiver.value + 1] - first;
  std::vector<PatchGain> gains(count);  // by unit, lx
  const std::span<const std::uint32_t> units = units_of(receiver);
  for (std::size_t p = 0; p < units.size(); ++p) {
    if (!(area_[units[p]] > 0)) continue;  // of nothing but inert patches
    gains[units[p] - first].gained += patches[p].gained / area_[units[p]];
    gains[units[p] - first].beyond += patches[p].beyond / area_[units[p]];
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t u = first + i;
    judge_correction(u, gains[i].gained);
    change_[u] = gains[i].gained;
    beyond_[u] = gains[i].beyond;
    pending_[u] = Spectrum{0};
  }
}

// Was what the unit was given in advance borne out by its gather, which changed it by so much more?
void Equilibrium::judge_correction(std::size_t u, const Spectrum& change) {
  const double given = luminance(pending_[u]), more = luminance(change);
  const double last = std::abs(luminance(change_[u]));
  const bool taken_back = given * more < 0 && std::abs(more) > kTakenBack * std::abs(given) &&
                          std::abs(more) >= kSettles * last;
  const double trust = trust_[u] * (taken_back ? kLessTrust : kMoreTrust);
  trust_[u] = std::clamp(trust, kLeastTrust, 1.0);
}

bool Equilibrium::learns() const { return sweeps_ < kLearning; }

namespace {

// Of each entry: itself, and its place in the copy of a channel's matrix that is solved with.
constexpr std::size_t kByEntry = sizeof(CoarseEntry) + sizeof(double) + sizeof(int);

}  // namespace

std::size_t Equilibrium::bytes() const {
  // Of each unit: its row's head, light of seven kinds, five sums, rank and size of the row; and a
  // dozen vectors of one channel while that is solved for, with a copy of its matrix.
  constexpr std::size_t kSpectra = 7, kSums = 5, kVectors = 12;
  constexpr std::size_t kByUnit = sizeof(std::vector<CoarseEntry>) + kSpectra * sizeof(Spectrum) +
                                  (kSums + kVectors) * sizeof(double) + 3 * sizeof(std::uint32_t);
  return entries_ * kByEntry + units() * kByUnit + unit_of_patch_.size() * sizeof(std::uint32_t) +
         2 * first_patch_.size() * sizeof(std::uint32_t);
}

std::uint64_t expected_coarse_bytes(const Model& model) {
  constexpr std::uint64_t kEntriesOfPair = 3;  // half of that in gen floor and building
  std::vector<ClusterId> order;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) order.push_back(ClusterId(c));
  return Equilibrium(model, order).bytes() +
         kEntriesOfPair * model.visible.items.size() * kByEntry;
}

void Equilibrium::sent(std::span<const UnitDetail> details) {
  for (const UnitDetail& d : details) {
    missed_[d.unit] += d.missed;
    sent_[d.unit] += d.sent;
    left_out_[d.unit] += d.left_out;
  }
}

std::vector<double> Equilibrium::detail_shares(ClusterId cluster) const {
  std::vector<double> shares;
  for (const std::uint32_t u : units_of(cluster)) shares.push_back(detail_share_[u]);
  return shares;
}

double Equilibrium::flux_pending() const {
  double flux = 0;
  for (std::size_t u = 0; u < units(); ++u) flux += area_[u] * luminance(pending_[u]);
  return flux;
}

namespace {

// Half of a building's entries are below this and hold a quarter percent of their rows. What they
// bring is brought by the others, so that a row still sums to what it did.
constexpr double kWeak = 1e-4;

void leave_out_weak(std::vector<CoarseEntry>& row) {
  Spectrum all{0}, strong{0};
  double all_factors = 0, strong_factors = 0;
  for (const CoarseEntry& e : row) {
    const bool weak = std::abs(e.form_factor) < kWeak;
    all += share_of(e);
    all_factors += e.form_factor;
    if (!weak) strong += share_of(e), strong_factors += e.form_factor;
  }
  if (!(strong_factors > 0.5 * all_factors)) return;  // all of it is weak
  std::erase_if(row, [](const CoarseEntry& e) { return std::abs(e.form_factor) < kWeak; });
  for (CoarseEntry& e : row) {
    for (int c = 0; c < kChannels; ++c) {
      float& share = e.share[std::size_t(c)];
      if (strong[c] > 0) share = float(share * (all[c] / strong[c]));
    }
    e.form_factor = float(e.form_factor * (all_factors / strong_factors));
  }
  row.shrink_to_fit();
}

}  // namespace

void Equilibrium::set_rows(const CoarseRows& rows) {
  for (std::size_t i = 0; i < rows.rows_.size(); ++i) {
    const std::size_t u = rows.first_ + i;
    const double kept = rows.linked_[i] > 0 ? 1 - rows.too_much_[i] / rows.linked_[i] : 1;
    const double made_up = rows.doubt_[i] > 0 ? rows.missing_[i] / rows.doubt_[i] : 0;
    std::vector<CoarseEntry> row;
    for (const CoarseRows::Entry& e : rows.rows_[i]) {
      const Spectrum share = (kept * e.share + made_up * e.doubt) / area_[u];
      const double factor = (kept * e.factors + made_up * e.doubts) / area_[u];
      row.push_back({e.unit, {float(share[0]), float(share[1]), float(share[2])}, float(factor)});
    }
    leave_out_weak(row);
    set_row(std::uint32_t(u), std::move(row));
  }
}

// (I - K) x = r, channel by channel over the same places.
std::vector<Spectrum> Equilibrium::solve(double reach, std::span<const Spectrum> residual) const {
  const auto n = Eigen::Index(units());
  const double damping = 1 - 1 / reach;
  SparseRows a(n, n);
  a.resizeNonZeros(n + Eigen::Index(entries_));  // the 1 of I beside what K has there
  int at = 0;
  for (Eigen::Index u = 0; u < n; ++u) {
    a.outerIndexPtr()[u] = at;
    a.innerIndexPtr()[at++] = int(u);
    for (const CoarseEntry& e : k_[u])
      if (e.unit != u) a.innerIndexPtr()[at++] = int(e.unit);
  }
  a.outerIndexPtr()[n] = at;
  a.resizeNonZeros(at);
  std::vector<Spectrum> x(units());
  Eigen::VectorXd b(n);
  for (int channel = 0; channel < kChannels; ++channel) {
    for (Eigen::Index u = 0; u < n; ++u) {
      double* value = a.valuePtr() + a.outerIndexPtr()[u];
      double& own = *value++ = 1;
      b[u] = residual[u][channel];
      for (const CoarseEntry& e : k_[u]) {
        double& place = e.unit == u ? own : *value++ = 0;
        place -= damping * e.share[channel];
      }
    }
    Eigen::BiCGSTAB<SparseRows, Eigen::DiagonalPreconditioner<double>> solver;
    solver.setTolerance(kSolved);
    solver.setMaxIterations(kMostSteps);
    solver.compute(a);
    const Eigen::VectorXd found = solver.solve(b);
    for (Eigen::Index u = 0; u < n; ++u) x[u][channel] = found[u];
  }
  return x;
}

void Equilibrium::forget() {
  last_change_ = 0;
  sweeps_ = 0;
  for (auto* sums : {&missed_, &sent_, &left_out_}) sums->assign(units(), 0);
}

bool Equilibrium::later(std::uint32_t v, std::uint32_t u) const {
  return rank_[v] > rank_[u] || (rank_[v] == rank_[u] && v >= u);
}

void Equilibrium::learn_detail_shares() {
  for (std::size_t u = 0; u < units(); ++u) {
    const double most = kMostMissed * sent_[u];
    const double missed = std::clamp(missed_[u], -most, most);
    detail_share_[u] = left_out_[u] > 0 ? std::clamp(missed / left_out_[u], -1.0, 1.0) : 0;
  }
  for (auto* sums : {&sent_, &missed_, &left_out_}) sums->assign(units(), 0);
}

void Equilibrium::correct(double change) {
  if (++sweeps_ <= kLearning) learn_detail_shares();
  if (last_change_ > 0 && !(change < kGrows * last_change_))
    reach_ = std::max(1.0, reach_ / kLessReach);
  last_change_ = change;
  std::vector<Spectrum> residual(units());
  for (std::size_t u = 0; u < units(); ++u) {
    residual[u] = -beyond_[u];
    const bool alone = !gathers(u);
    if (alone) residual[u] += owed_[u];
    for (const CoarseEntry& e : k_[u])
      if (alone || later(e.unit, std::uint32_t(u)))
        residual[u] += share_of(e) * change_[e.unit];
  }
  solve_for(residual);
}

// What is owed where nothing is gathered is what this leaves over of its residual.
void Equilibrium::solve_for(std::span<const Spectrum> residual) {
  std::vector<Spectrum> x = solve(reach_, residual);
  for (std::size_t u = 0; u < units(); ++u) x[u] *= trust_[u];
  for (std::size_t u = 0; u < units(); ++u) {
    if (gathers(u)) {
      pending_[u] = x[u];
      continue;
    }
    pending_[u] += x[u];
    came_[u] += x[u];
    owed_[u] = residual[u] - x[u];
    for (const CoarseEntry& e : k_[u]) owed_[u] += share_of(e) * x[e.unit];
  }
}

Status Equilibrium::take_over(ClusterStore& before, std::size_t units_before,
                              std::span<const UnitEdit> edits) {
  std::vector<std::uint32_t> now(units_before, UnitEdit::kNew);
  for (std::size_t u = 0; u < units(); ++u)
    if (edits[u].before != UnitEdit::kNew) now[edits[u].before] = std::uint32_t(u);
  std::vector<Spectrum> residual(units(), Spectrum{0});
  const auto take_row = [&](std::size_t unit, std::span<const CoarseFactor> factors) {
    const std::uint32_t u = now[unit];
    if (u == UnitEdit::kNew) return;
    std::vector<CoarseEntry> row;
    for (const CoarseFactor& f : factors) {
      const std::uint32_t from = f.unit < now.size() ? now[f.unit] : UnitEdit::kNew;
      if (from == UnitEdit::kNew) continue;
      const UnitEdit& source = edits[from];
      const Spectrum share = double(f.form_factor) * source.reflectance;
      row.push_back({from, {float(share[0]), float(share[1]), float(share[2])}, f.form_factor});
      residual[u] += double(f.form_factor) * source.change;
    }
    std::ranges::sort(row, {}, &CoarseEntry::unit);
    row.shrink_to_fit();
    set_row(u, std::move(row));
  };
  const Result<std::vector<double>> shares = read_coarse_factors(before, units_before, take_row);
  if (!shares.ok()) return shares.status();
  for (std::size_t u = 0; u < units(); ++u)
    if (edits[u].before != UnitEdit::kNew) detail_share_[u] = (*shares)[edits[u].before];
  sweeps_ = kLearning;  // shares of detail are of all that sees a unit, and not learnt from a part
  reached_.assign(reached_.size(), Reached::kNot);
  solve_for(residual);
  return {};
}

void Equilibrium::begin_sweep() {
  std::ranges::replace(reached_, Reached::kNext, Reached::kNow);
}

double Equilibrium::come_by_itself(ClusterId cluster) const {
  double most = 0;
  for (std::uint32_t u = first_unit_[cluster.value]; u < first_unit_[cluster.value + 1]; ++u)
    for (int c = 0; c < kChannels; ++c) most = std::max(most, std::abs(came_[u][c]));
  return most;
}

double Equilibrium::flux_awaited() const {
  double flux = 0;
  for (std::size_t u = 0; u < units(); ++u)
    if (gathers(u)) flux += areas()[u] * std::abs(luminance(pending_[u]));
  return flux;
}

bool Equilibrium::anything_pending(ClusterId cluster) const {
  for (std::uint32_t u = first_unit_[cluster.value]; u < first_unit_[cluster.value + 1]; ++u)
    if (pending_[u] != Spectrum{0}) return true;
  return false;
}

void Equilibrium::put_in(ClusterId cluster) {
  for (std::uint32_t u = first_unit_[cluster.value]; u < first_unit_[cluster.value + 1]; ++u)
    pending_[u] = Spectrum{0};
}

void Equilibrium::spread_gains() {
  const std::vector<Spectrum> x = solve(kGainsReach, change_);
  for (std::size_t u = 0; u < units(); ++u) pending_[u] = x[u] - change_[u];
}

namespace {

Status put_sizes(std::span<const std::vector<CoarseEntry>> rows, PiecesOut& out) {
  std::vector<std::uint32_t> sizes;
  for (const auto& row : rows) sizes.push_back(std::uint32_t(row.size()));
  return out.put(std::span(std::as_const(sizes)));
}

}  // namespace

// Head, sizes of the rows, their entries, then by unit the change, what of it went beyond, what is
// pending, owed and came; then the sums of what it sent, its share of detail, and the trust; then by
// cluster its reach.
Status Equilibrium::save(ClusterStore& store) const {
  PiecesOut out(store, RecordKind::kEquilibrium);
  const Head head{units(), sweeps_, reach_, last_change_};
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(&head, 1)));
  ATRIUM_RETURN_IF_ERROR(put_sizes(k_, out));
  for (const auto& row : k_) ATRIUM_RETURN_IF_ERROR(out.put(std::span(row)));
  for (const auto* light : {&change_, &beyond_, &pending_, &owed_, &came_})
    ATRIUM_RETURN_IF_ERROR(out.put(std::span(*light)));
  for (const auto* sums : {&sent_, &missed_, &left_out_, &detail_share_, &trust_})
    ATRIUM_RETURN_IF_ERROR(out.put(std::span(*sums)));
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(reached_)));
  return out.finish();
}

Status Equilibrium::restore(ClusterStore& store) {
  PiecesIn in(store, RecordKind::kEquilibrium);
  std::vector<Head> head;
  std::vector<std::uint32_t> sizes;
  ATRIUM_RETURN_IF_ERROR(in.get(head, 1));
  if (head[0].units != units()) return of_other_units(RecordKind::kEquilibrium);
  ATRIUM_RETURN_IF_ERROR(in.get(sizes, units()));
  for (std::size_t u = 0; u < units(); ++u) {
    std::vector<CoarseEntry> row;
    ATRIUM_RETURN_IF_ERROR(in.get(row, sizes[u]));
    set_row(std::uint32_t(u), std::move(row));
  }
  for (auto* light : {&change_, &beyond_, &pending_, &owed_, &came_})
    ATRIUM_RETURN_IF_ERROR(in.get(*light, units()));
  for (auto* sums : {&sent_, &missed_, &left_out_, &detail_share_, &trust_})
    ATRIUM_RETURN_IF_ERROR(in.get(*sums, units()));
  ATRIUM_RETURN_IF_ERROR(in.get(reached_, reached_.size()));
  sweeps_ = head[0].sweeps;
  reach_ = head[0].reach;
  last_change_ = head[0].last_change;
  return in.finish();
}

// Units, sizes of the rows, their entries, shares of detail. (pagestore/FORMAT.md)
Status Equilibrium::leave_factors(ClusterStore& store) const {
  PiecesOut out(store, RecordKind::kFactors);
  const std::uint64_t count = units();
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(&count, 1)));
  ATRIUM_RETURN_IF_ERROR(put_sizes(k_, out));
  for (const auto& row : k_)
    for (const CoarseEntry& e : row) {
      const CoarseFactor factor{e.unit, e.form_factor};
      ATRIUM_RETURN_IF_ERROR(out.put(std::span(&factor, 1)));
    }
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(detail_share_)));
  return out.finish();
}

Result<std::vector<double>> read_coarse_factors(ClusterStore& store, std::size_t units,
                                                const CoarseFactorRow& visit) {
  PiecesIn in(store, RecordKind::kFactors);
  std::vector<std::uint64_t> count;
  std::vector<std::uint32_t> sizes;
  ATRIUM_RETURN_IF_ERROR(in.get(count, 1));
  if (count[0] != units) return of_other_units(RecordKind::kFactors);
  ATRIUM_RETURN_IF_ERROR(in.get(sizes, units));
  std::vector<CoarseFactor> row;
  for (std::size_t u = 0; u < units; ++u) {
    ATRIUM_RETURN_IF_ERROR(in.get(row, sizes[u]));
    visit(u, row);
  }
  std::vector<double> shares;
  ATRIUM_RETURN_IF_ERROR(in.get(shares, units));
  ATRIUM_RETURN_IF_ERROR(in.finish());
  return shares;
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
  std::vector<Entry> block(rows_.size() * width);
  // A group is of the unit that its patches are of.
  const auto row_of = [&](const Braid::Strand& s) -> std::size_t {
    if (s.patch < to.size()) return to[s.patch] - first_;
    return to[groups.any_patch(groups.groups[s.patch - to.size()])] - first_;
  };
  const auto entry = [&](const Braid::Strand& s, std::uint32_t source_patch) -> Entry& {
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
    return source_patch < from.size()
               ? source.patch_head(source_patch).reflectance
               : source.groups().groups[source_patch - from.size()].reflectance;
  };
  const auto put = [&](const Braid::Strand& s, const LinkHead& link, double coupling) {
    const double f = coupling * area_of(s, link);
    Entry& e = entry(s, link.source_patch);
    e.share += f * reflectance_of(link.source_patch);
    e.factors += f;
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
      Entry& e = entry(s, d.source_patch);
      e.doubt += double(d.weight) * reflectance_of(d.source_patch);
      e.doubts += d.weight;
      doubt_[row_of(s)] += d.weight;
    }
  }
  for (std::size_t u = 0; u < rows_.size(); ++u)
    for (std::size_t v = 0; v < width; ++v) {
      Entry e = block[u * width + v];
      e.unit = std::uint32_t(first + v);
      if (!e.none()) rows_[u].push_back(e);
    }
}

void CoarseRows::close(std::size_t patch, const PatchTree& tree, const Closing& closing) {
  const std::size_t u = equilibrium_.units_of(receiver_)[patch] - first_;
  if (too_much(closing))
    too_much_[u] -= closing.missing * tree.head.area;
  else if (closing.how != Closing::How::kOpen)
    missing_[u] += closing.missing * tree.head.area;
}

}  // namespace atrium
