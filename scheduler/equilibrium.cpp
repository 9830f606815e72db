#include "scheduler/equilibrium.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/squared.h"
#include "scheduler/record_pieces.h"
#include "scheduler/stored_patches.h"

namespace atrium {

namespace {

// Bounces that a correction looks ahead: as many as paint of ρ = .99999 asks for and a hundred
// times more, so that white rooms find their level at once. Where a sweep changes so many times as
// much as the least of its level that was too far.
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

struct Head {
  std::uint64_t units = 0, sweeps = 0;
  double reach = 0, least_change = 0;
};

Status of_other_units(RecordKind kind) {
  return Status(Code::kStore, "", to_string(record_id(kind, 0)), "it is not of this model's units",
                "run atrium check on the run");
}
}  // namespace

Equilibrium::Equilibrium(const Model& model, std::span<const ClusterId> order, Division division)
    : units_(model, division), rank_(model.clusters.size()), reach_(kFarthest) {
  for (std::size_t i = 0; i < order.size(); ++i) rank_[order[i].value] = std::uint32_t(i);
  k_.resize(units());
  change_.assign(units(), Spectrum{0});
  beyond_.assign(units(), Spectrum{0});
  pending_.assign(units(), Spectrum{0});
  light_.assign(units(), Spectrum{0});
  trust_.assign(units(), 1);
  for (auto* sums : {&missed_, &sent_, &left_out_, &detail_share_}) sums->assign(units(), 0);
  reached_.assign(model.clusters.size(), Reached::kNow);
  for (auto* light : {&owed_, &came_}) light->assign(units(), Spectrum{0});
}

std::vector<std::uint32_t> Equilibrium::by_unit(ClusterId cluster) const {
  const std::span<const std::uint32_t> units = units_of(cluster);
  std::vector<std::uint32_t> patches(units.size());
  std::iota(patches.begin(), patches.end(), 0u);
  std::ranges::stable_sort(patches, {}, [&](std::uint32_t p) { return units[p]; });
  return patches;
}

void Equilibrium::gathered(ClusterId receiver, std::span<const PatchGain> patches) {
  const std::vector<PlaceGain> gains = units_.gains(receiver, patches);
  for (std::size_t i = 0; i < gains.size(); ++i) {
    const std::size_t u = units_.first(receiver) + i;
    const double area = areas()[u];
    if (!(area > 0)) continue;  // of nothing but inert patches
    const Spectrum change = gains[i].gained / area;
    judge_correction(u, change);
    change_[u] = change;
    beyond_[u] = gains[i].beyond / area;
    light_[u] += pending_[u] + change;
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
  // Of each unit: its row's head, light of six kinds, five sums; and, while it is solved for, light
  // of two kinds, 32 vectors of one channel, and its patch's number and row's head in the copy of a
  // channel's matrix.
  constexpr std::size_t kSpectra = 6 + 2, kSums = 5, kVectors = 32;
  constexpr std::size_t kByUnit = sizeof(std::vector<CoarseEntry>) + kSpectra * sizeof(Spectrum) +
                                  (kSums + kVectors) * sizeof(double) + 3 * sizeof(std::uint32_t);
  return entries_ * kByEntry + units() * kByUnit + units_.bytes() +
         rank_.size() * (sizeof(std::uint32_t) + sizeof(Reached));
}

std::uint64_t expected_coarse_bytes(const Model& model) {
  constexpr Division kDivision = Division::kWhereItPays;
  const Equilibrium equilibrium(model, all_clusters(model), kDivision);
  const CoarseUnits& units = equilibrium.coarse_units();
  if (units.size() == 0) return 0;
  // As many as pairs of parts, and twice that: rooms of few patches have more a pair of clusters.
  const double parts = double(units.size()) / (undivided_numbers(units).back() + 1);
  const double entries = undivided_entries(model) * (parts > 1 ? 2 * squared(parts) : 1);
  return equilibrium.bytes() + std::uint64_t(entries) * kByEntry;
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
  for (std::size_t u = 0; u < units(); ++u) flux += areas()[u] * luminance(pending_[u]);
  return flux;
}

void Equilibrium::set_rows(const CoarseRows& rows) {
  const ClusterId receiver = rows.receiver();
  for (std::uint32_t u = units_.first(receiver); u < units_.end(receiver); ++u)
    set_row(u, rows.row(u));
}

void Equilibrium::forget() {
  least_change_ = 0;
  sweeps_ = 0;
  for (auto* sums : {&missed_, &sent_, &left_out_}) sums->assign(units(), 0);
}

bool Equilibrium::later(std::uint32_t v, std::uint32_t u) const {
  const std::uint32_t of_v = rank_[units_.cluster_of(v).value];
  const std::uint32_t of_u = rank_[units_.cluster_of(u).value];
  return of_v > of_u || (of_v == of_u && v >= u);
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
  if (least_change_ > 0 && !(change < kGrows * least_change_))
    reach_ = std::max(1.0, reach_ / kLessReach);
  least_change_ = least_change_ > 0 ? std::min(least_change_, change) : change;
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
  std::vector<Spectrum> x = solve_coarse(units_, k_, 1 - 1 / reach_, residual);
  for (std::size_t u = 0; u < units(); ++u) x[u] *= trust_[u];
  for (std::size_t u = 0; u < units(); ++u) {
    if (gathers(u)) {
      pending_[u] = glm::max(x[u], -glm::max(light_[u], Spectrum{0}));
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
  light_.assign(units(), Spectrum{std::numeric_limits<double>::infinity()});
  solve_for(residual);
  return {};
}

void Equilibrium::begin_sweep() {
  std::ranges::replace(reached_, Reached::kNext, Reached::kNow);
}

double Equilibrium::come_by_itself(ClusterId cluster) const {
  double most = 0;
  for (std::uint32_t u = units_.first(cluster); u < units_.end(cluster); ++u)
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
  for (std::uint32_t u = units_.first(cluster); u < units_.end(cluster); ++u)
    if (pending_[u] != Spectrum{0}) return true;
  return false;
}

void Equilibrium::put_in(ClusterId cluster) {
  for (std::uint32_t u = units_.first(cluster); u < units_.end(cluster); ++u) {
    light_[u] += pending_[u];
    pending_[u] = Spectrum{0};
  }
}

void Equilibrium::spread_gains() {
  const std::vector<Spectrum> x = solve_coarse(units_, k_, 1 - 1 / kGainsReach, change_);
  for (std::size_t u = 0; u < units(); ++u) {
    pending_[u] = x[u] - change_[u];
    light_[u] -= change_[u];  // it is put in yet
  }
}

namespace {

Status put_sizes(std::span<const std::vector<CoarseEntry>> rows, PiecesOut& out) {
  std::vector<std::uint32_t> sizes;
  for (const auto& row : rows) sizes.push_back(std::uint32_t(row.size()));
  return out.put(std::span(std::as_const(sizes)));
}

}  // namespace

// Head, sizes of the rows, their entries, then by unit the change, what of it went beyond, what is
// pending, stored, owed and came; then its area, the sums of what it sent, its share of detail, and
// the trust; then by cluster its reach.
Status Equilibrium::save(ClusterStore& store) const {
  PiecesOut out(store, RecordKind::kEquilibrium);
  const Head head{units(), sweeps_, reach_, least_change_};
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(&head, 1)));
  ATRIUM_RETURN_IF_ERROR(put_sizes(k_, out));
  for (const auto& row : k_) ATRIUM_RETURN_IF_ERROR(out.put(std::span(row)));
  for (const auto* light : {&change_, &beyond_, &pending_, &light_, &owed_, &came_})
    ATRIUM_RETURN_IF_ERROR(out.put(std::span(*light)));
  ATRIUM_RETURN_IF_ERROR(out.put(areas()));
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
  for (auto* light : {&change_, &beyond_, &pending_, &light_, &owed_, &came_})
    ATRIUM_RETURN_IF_ERROR(in.get(*light, units()));
  for (auto* sums : {&units_.areas(), &sent_, &missed_, &left_out_, &detail_share_, &trust_})
    ATRIUM_RETURN_IF_ERROR(in.get(*sums, units()));
  ATRIUM_RETURN_IF_ERROR(in.get(reached_, reached_.size()));
  sweeps_ = head[0].sweeps;
  reach_ = head[0].reach;
  least_change_ = head[0].least_change;
  return in.finish();
}

std::vector<CoarseFactor> Equilibrium::undivided_row(std::uint32_t first,
                                                     std::span<const std::uint32_t> number) const {
  std::vector<std::pair<std::uint32_t, double>> parts;  // source, m²
  double area = 0;
  for (std::size_t u = first; u < first + units_.parts(first); ++u) {
    area += areas()[u];
    for (const CoarseEntry& e : k_[u])
      parts.emplace_back(number[e.unit], areas()[u] * double(e.form_factor));
  }
  std::ranges::stable_sort(parts, {}, [](const auto& p) { return p.first; });
  std::vector<CoarseFactor> row;
  for (auto p = parts.begin(); p != parts.end();) {
    const std::uint32_t source = p->first;
    double sum = 0;
    for (; p != parts.end() && p->first == source; ++p) sum += p->second;
    row.push_back({source, float(sum / area)});
  }
  return row;
}

// Units, sizes of the rows, their entries, shares of detail: as of patches that are not divided.
// (pagestore/FORMAT.md)
Status Equilibrium::leave_factors(ClusterStore& store) const {
  const std::vector<std::uint32_t> number = undivided_numbers(units_);
  std::vector<std::uint32_t> undivided, sizes;
  std::vector<double> shares;
  for (std::uint32_t u = 0; u < units(); u += std::uint32_t(units_.parts(u))) {
    undivided.push_back(u);
    sizes.push_back(std::uint32_t(undivided_row(u, number).size()));
    shares.push_back(detail_share_[u]);
  }
  PiecesOut out(store, RecordKind::kFactors);
  const std::uint64_t count = undivided.size();
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(&count, 1)));
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(std::as_const(sizes))));
  for (const std::uint32_t u : undivided) {
    const std::vector<CoarseFactor> row = undivided_row(u, number);
    ATRIUM_RETURN_IF_ERROR(out.put(std::span(row)));
  }
  ATRIUM_RETURN_IF_ERROR(out.put(std::span(std::as_const(shares))));
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

}  // namespace atrium
