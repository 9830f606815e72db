// Warm start: a solve that begins from another run's solution, of the scene as it was before an
// edit, and gathers only to what the edit reaches.
//
// Both models are compared by content, never by name or number: a patch is the same where its
// outline is, bit for bit. Its elements and its light are taken over; where surfaces that touch it
// have moved, its outline's light alone. A cluster is gathered to if
//
//   its shape is new, or what stands on its surfaces is;
//   it may see what was moved, put in or taken out, which may have stood in its light;
//   what lamps and paint that changed make of its light, by the coarse system of the old run's
//   links (equilibrium.h), is more than a share of the error asked for. After each sweep it is told
//   by what gathers have really changed, and clusters join that it did not tell of at first.
//
// All others keep their light but for what the coarse system adds to it. What is gathered to is
// linked anew, as finely as the old run's last links were; the old ones are gone with that run.
// That takes a sweep over few clusters, and of a run its records and one more, the form factors
// between units. Braids are more than twice the bytes of the solution that they led to, and every
// run would have to keep them for an edit that may never come.
//
// Invariants:
//  1. The old run is read and never written. Once the new one's first records are durable it is not
//     needed any more.
//  2. Where nothing can be taken over, it is a fresh solve, and where nothing has changed nothing
//     is gathered.
//  3. Functions of both models, the old solution and the options: the same bits however often the
//     new run is stopped and resumed.
// Not thread safe.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/status.h"
#include "scheduler/equilibrium.h"
#include "scheduler/plan.h"
#include "scheduler/run_state.h"
#include "scheduler/solution.h"

namespace atrium {

class WarmStart {
 public:
  // The run that options.from names, compared with the scene. kUsage: it has not ended, is of
  // another basis, or less exact than what is asked for; its model and this one are too much for
  // the memory. Both arguments outlive it.
  static Result<std::unique_ptr<WarmStart>> open(const SolveOptions& options,
                                                 const Prepared& prepared);

  // Bytes: of a fresh solve, and of the old model beside it.
  std::uint64_t smallest_memory() const { return smallest_memory_; }
  // False: it is a fresh solve.
  bool takes_over() const { return kept_.patches_kept > 0 && light_.flux_in > 0; }
  // A cluster's trees to begin with.
  Result<std::vector<PatchTree>> trees_of(ClusterId cluster);

  // Where the iteration stands at its begin, and whom it gathers to.
  Status begin(Equilibrium& equilibrium, Cursor& cursor) const;

  // What is kept; and what begin found to be reached.
  WarmFigures figures(const Equilibrium& equilibrium) const;
  // Of the old run, where nothing is gathered anew.
  const ErrorEstimate& estimate() const { return state_.figures.estimate; }

 private:
  // What a patch was in the old model, and what the edit has made of it.
  struct Origin {
    PatchId before;        // none: it is new
    bool touched = false;  // what meets it has changed
    Spectrum change{0};    // lm/m², of its mean B, in the light that it had
  };

  WarmStart(const SolveOptions& options, const Prepared& prepared)
      : options_(options), prepared_(prepared), model_(prepared.model) {}
  Status open_run();
  void match_patches();
  void match_clusters();
  Status compare();
  void compare(std::uint32_t patch, const PatchTree& planted, const ClusterView* before);
  void look_for_moved();
  void forget_what_was_seen();
  void see_anew(std::span<const ClusterId> clusters);
  Result<const ClusterView*> cluster_before(PatchId patch);
  PatchTree plant_anew(std::uint32_t patch) const;
  std::vector<UnitEdit> edits(const Equilibrium& equilibrium) const;

  const SolveOptions& options_;
  const Prepared& prepared_;
  const Model& model_;
  std::unique_ptr<ClusterStore> store_;
  RunModel run_;  // once it is compared, its patches and clusters alone
  std::uint64_t smallest_memory_ = 0;
  RunState state_;
  std::optional<Equilibrium> units_;      // of the old run
  std::vector<Origin> origins_;           // by patch
  std::vector<ClusterId> same_shape_as_;  // by cluster, in the old model; none: a new shape
  std::vector<ClusterId> now_;            // by old cluster: what it is; none: it is gone
  std::vector<bool> changed_;             // by cluster: it, or what touches it
  std::vector<bool> sees_anew_;           // by cluster: something that it may see has moved
  PushPullSums light_;                    // that it begins with
  WarmFigures kept_;
  ClusterId read_;                        // the old cluster that was read last,
  std::optional<ClusterView> view_;       // and its record
};

// "kept 120 of 130 patches …": of a scene that plan tells of.
std::string in_words(const WarmFigures& figures, const Plan& plan);

// A cluster that is not gathered to, as a gather would report it.
Result<GatherReport> at_rest(ClusterStore& store, ClusterId cluster);

// Marks the clusters that are reached by what has come to them since; how many.
std::uint64_t reach_further(const SolveOptions& options, const Model& model,
                            double mean_irradiance, Equilibrium& equilibrium);

// What is pending of clusters that are not gathered to becomes part of their records.
Status put_in_pending(ClusterStore& store, const Model& model, Equilibrium& equilibrium);

}  // namespace atrium
