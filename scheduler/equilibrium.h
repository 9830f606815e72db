// Equilibrium: the slow modes of the iteration, taken out by a coarse system. Light that goes round
// and round between white walls changes little from sweep to sweep and takes hundreds of them; seen
// from far it is one number a wall, and those have an equilibrium that can be solved for at once.
//
// Units are patches, what is left of clusters, and where it pays parts of patches (coarse_units.h).
// The matrix K holds for each pair of units what the links of this level, and the closing of their
// rows, make of a unit's mean irradiance in another's (coarse_rows.h). After a sweep the residual
// is what sources that came later have changed, carried by K, less what the unit's own gather was
// taken beyond (solver/push_pull.h); (I - K) x = residual gives what is still to come
// (coarse_solve.h), and x is pending: it is added to a unit's E where it is read, and becomes part
// of what is stored when the unit's cluster is gathered to. So the fixed point is that of the plain
// iteration, and the records are not passed over once more.
//
// Residual form, a matrix that stays: corrections from fluxes measured during a sweep oscillate
// where paint is white. [facts/radiosity.md, stiffness] What is left to the sweeps are modes inside
// of units; mixing the last sweeps' unit means (Anderson) does not see them, and made things worse.
//
// Light is never negative: no correction takes more of a unit than it has. Its gather would take
// that back, which is no light that has come, and was sent on as if it were: in the dark inside of
// a white box, of which rows were a little too much, a hundred times what it was, each sweep.
//
// Two things are learnt by unit from sweep to sweep. Trust: a correction that the unit's gather
// takes back is taken in part the next time; a mean does not tell what a patch sees that sees one
// corner of a unit. Shares of detail: what links from coarse elements leave out (solver/gather.h).
//
// A solve that begins from another one's solution (warm_start.h) gathers only to clusters that the
// change reaches. To the units of others light comes by K alone: what they are owed is solved for
// with the rest, and adds up in what is pending of them until it is put into their records.
//
// Not thread safe, apart from reading what is pending.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine/model.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/coarse_rows.h"
#include "scheduler/coarse_solve.h"
#include "scheduler/coarse_units.h"

namespace atrium {

// What gathers have brought of a unit's light. (solver/gather.h, SentDetail)
struct UnitDetail {
  std::uint32_t unit = 0;
  double sent = 0;      // lm, luminance
  double missed = 0;    // lm: what its patches' means would have sent, less that
  double left_out = 0;  // lm, of detail, by links from coarse elements
};

// What an edit of the scene has made of a unit.
struct UnitEdit {
  static constexpr std::uint32_t kNew = ~std::uint32_t{0};
  std::uint32_t before = kNew;  // its number in the old model
  Spectrum reflectance{0};      // mean, as it is now
  Spectrum change{0};           // lm/m², mean B, in the light that it had
};

// What a run that has ended keeps of its coarse system, for one that starts from it, is K without
// paint, eight bytes an entry, and by unit the shares of detail.
struct CoarseFactor {
  std::uint32_t unit = 0;  // the source
  float form_factor = 0;
};
// Called with the row of each unit, from 0 on.
using CoarseFactorRow = std::function<void(std::size_t unit, std::span<const CoarseFactor>)>;
// Reads them row by row; returns the shares. kStore: they are not of so many units, or shorter or
// longer than they say.
Result<std::vector<double>> read_coarse_factors(ClusterStore& store, std::size_t units,
                                                const CoarseFactorRow& row);

// Is a cluster gathered to?
enum class Reached : std::uint8_t {
  kNot,
  kNext,  // from the next sweep on
  kNow
};

class Equilibrium {
 public:
  Equilibrium(const Model& model, std::span<const ClusterId> order,
              Division division = Division::kNone);

  std::size_t units() const { return units_.size(); }
  const CoarseUnits& coarse_units() const { return units_; }
  // To be added to E where it is read.
  PlacedLight pending(ClusterId cluster) const { return units_.placed(cluster, pending_); }
  // By local patch; the first of its parts where it is divided.
  std::span<const std::uint32_t> units_of(ClusterId cluster) const { return units_.of(cluster); }
  // Local patches, those of one unit together: the order of a gather within the cluster.
  std::vector<std::uint32_t> by_unit(ClusterId cluster) const;

  // Where its links were made anew.
  void set_rows(const CoarseRows& rows);
  void set_row(std::uint32_t unit, std::vector<CoarseEntry> row) {
    entries_ += row.size() - k_[unit].size();
    k_[unit] = std::move(row);
  }

  // As the records of kind kFactors.
  Status leave_factors(ClusterStore& store) const;
  // Takes over what another solve of so many units has left, and spreads what the edit changes of
  // their B. No cluster is reached by it yet. kStore: as read_coarse_factors; then it is of no use.
  Status take_over(ClusterStore& before, std::size_t units_before, std::span<const UnitEdit> edits);
  // Whom sweeps gather to: all, but after take_over.
  Reached reached(ClusterId cluster) const { return reached_[cluster.value]; }
  void reach(ClusterId cluster) {
    if (reached_[cluster.value] == Reached::kNot) reached_[cluster.value] = Reached::kNext;
  }
  void begin_sweep();
  // lx: what has come to a unit of it beside all gathers, at the most.
  double come_by_itself(ClusterId cluster) const;
  bool anything_pending(ClusterId cluster) const;
  // What was pending of it is part of what is stored.
  void put_in(ClusterId cluster);
  // m², by unit.
  std::span<const double> areas() const { return units_.areas(); }
  // A complete gather to a cluster: nothing is pending of it any more.
  void gathered(ClusterId receiver, std::span<const PatchGain> patches);

  void sent(std::span<const UnitDetail> details);
  // Asks for what links bring: in the first sweeps of a level.
  bool learns() const;
  // Memory: what it holds, and what a correction takes beside it.
  std::size_t bytes() const;
  // The unit that all members of its face groups are in.
  std::uint32_t rest_unit(ClusterId cluster) const { return units_.first(cluster); }
  // By local patch, of this level: the share of its detail that coarse links bring.
  std::vector<double> detail_shares(ClusterId cluster) const;

  // lm, luminance of all that is pending.
  double flux_pending() const;
  // The same of either sign, where sweeps gather: what the next one is to change by it.
  double flux_awaited() const;
  // After a complete sweep, which changed so much: what is still to come, as far as units tell.
  void correct(double change);
  // What was gained beside the links, by a local pass: pending is what that sends on.
  void spread_gains();
  // Links are made anew: what was learnt of the iteration with the old ones does not hold.
  void forget();

  // All of it that is not a function of model and order, for a checkpoint, as the records of kind
  // kEquilibrium; and back. kStore: they are not of as many units, or shorter or longer than they
  // say.
  Status save(ClusterStore& store) const;
  Status restore(ClusterStore& store);

 private:
  // Of a patch, as if none were divided; number: of a source, by its first part.
  std::vector<CoarseFactor> undivided_row(std::uint32_t first_part,
                                          std::span<const std::uint32_t> number) const;
  void learn_detail_shares();
  void judge_correction(std::size_t unit, const Spectrum& change);
  bool gathers(std::size_t unit) const {
    return reached(units_.cluster_of(unit)) == Reached::kNow;
  }
  void solve_for(std::span<const Spectrum> residual);
  // What v has changed in a sweep, u's gather in it has not seen. Nor, at large, what its own
  // patches have.
  bool later(std::uint32_t v, std::uint32_t u) const;

  CoarseUnits units_;
  std::vector<std::uint32_t> rank_;               // by cluster: its place in the order
  CoarseMatrix k_;                                // sources ascend
  std::size_t entries_ = 0;                       // of all rows
  std::vector<Spectrum> change_;                  // lx, of this sweep, by unit
  std::vector<Spectrum> beyond_;                  // lx, of change_, by unit
  double reach_;                                  // bounces that a correction looks ahead
  double least_change_ = 0;                       // of this level; 0: none yet
  std::vector<Spectrum> pending_;                 // lx, by unit
  std::vector<Spectrum> light_;                   // lx, by unit, as stored; infinite: not known
  std::uint64_t sweeps_ = 0;                      // of this level
  std::vector<double> sent_, missed_, left_out_;  // lm, by unit, of this sweep: UnitDetail's
  std::vector<double> detail_share_;              // by unit
  std::vector<double> trust_;                     // by unit: share of its correction that is taken
  std::vector<Reached> reached_;                      // by cluster
  // lx, by unit that is not gathered to: come by K and not in pending_ yet; all that ever was.
  std::vector<Spectrum> owed_, came_;
};

// Memory that it will take, before there are any links: by the pairs of clusters that may see each
// other.
std::uint64_t expected_coarse_bytes(const Model& model);

}  // namespace atrium
