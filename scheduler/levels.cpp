#include "scheduler/levels.h"

#include <algorithm>

#include "engine/squared.h"

namespace atrium {

namespace {

// Link threshold of the last level ÷ error asked for: found on the scenes with references, so that
// what is asked for is about what the truth says.
constexpr double kThresholdOfError = 0.005;

bool at_last_level(const Cursor& cursor) { return cursor.level + 1 == kLevels.size(); }

// Light still to come if each sweep adds q times what the last one did, as a share of all; before q
// is known, that it is no more than what the sweep has changed.
double rest_of_light(const Cursor& cursor, double change) {
  if (cursor.sweep == 0 || !(cursor.last_change > 0)) return change;
  constexpr double kSlowest = 0.9999;
  const double q = std::clamp(change / cursor.last_change, 0.0, kSlowest);
  return change * std::max(1.0, q / (1 - q));
}

// Has the iteration stalled, by the sweep that ended?
bool stalled(Cursor& cursor, const SweepOutcome& sweep) {
  const double progress = (sweep.noisy ? kNoisyProgress : 1) * cursor.least_change;
  const bool falls = cursor.sweep <= 1 || sweep.change < progress;
  cursor.stalled = falls ? 0 : cursor.stalled + 1;
  if (falls) cursor.least_change = sweep.change;
  return cursor.stalled >= (sweep.noisy ? kNoisySweeps : kStalledSweeps);
}

// Is the light still to come little enough for what the level's answer is wanted for? A coarse
// level may end while some is awaited: the next one's links bring it.
bool settled(const Cursor& cursor, const SolveOptions& options, double by_sweeps) {
  if (cursor.settling) return cursor.rest < kTakenRestOfError * options.error;
  return at_last_level(cursor) ? cursor.rest < kFineRestOfError * options.error
                               : by_sweeps < kCoarseRest;
}

// The next level, or the last one over again; its link threshold is so many times what it would be.
Next begin_level(Cursor& cursor, double threshold) {
  if (!at_last_level(cursor)) ++cursor.level;
  cursor.threshold *= threshold;
  cursor.phase = Phase::kLinks;
  cursor.mended = 0;
  cursor.settling = 0;
  cursor.sweep = 0;
  return {.level_begins = true};
}

// Ends that going on would not change: a run that is taken up again ends so at once.
Next end_for_good(Cursor& cursor, Stop stop) {
  cursor.done = static_cast<std::uint32_t>(stop);
  return {.stop = stop};
}

// An answer that is exact enough: taken once it has settled.
Next take(Cursor& cursor, const SolveOptions& options) {
  const bool has_settled = cursor.settling || cursor.mended ||
                           cursor.rest < kTakenRestOfError * options.error ||
                           options.links == "discard";
  cursor.settling = 1;
  cursor.phase = Phase::kLinks;
  return has_settled ? end_for_good(cursor, Stop::kConverged) : Next{};
}

// Links as fine as the estimate says is needed, and no finer than the next level's.
Next make_finer(Cursor& cursor, double finer) {
  if (!at_last_level(cursor))
    return begin_level(cursor,
                       std::max(1.0, finer * kLevels[cursor.level] / kLevels[cursor.level + 1]));
  // What is left to the last level's own threshold is gone first, unless that is hardly a step.
  const double left = 1 / cursor.threshold;
  if (left <= kLoosest) return begin_level(cursor, std::max(left, finer));
  if (cursor.tightened == kMostTightened) return end_for_good(cursor, Stop::kTooCoarse);
  ++cursor.tightened;
  return begin_level(cursor, finer);
}

}  // namespace

const char* reason(Stop stop) {
  switch (stop) {
    case Stop::kConverged: return "converged";
    case Stop::kResidual: return "residual reached";
    case Stop::kIterations: return "iteration limit";
    case Stop::kTime: return "time limit";
    case Stop::kRequested: return "stopped on request";
    case Stop::kStalled: return "no longer converging";
    case Stop::kTooCoarse: return "estimated error above what was asked";
    case Stop::kFailed: return "failed";
    case Stop::kNone: break;
  }
  return "";
}

int exit_code(Stop stop) {
  if (stop == Stop::kRequested) return static_cast<int>(Code::kStopped);
  const bool limit = stop == Stop::kIterations || stop == Stop::kTime || stop == Stop::kStalled ||
                     stop == Stop::kTooCoarse;
  return limit ? static_cast<int>(Code::kLimit) : 0;
}

double link_threshold(const Cursor& cursor, const SolveOptions& options) {
  return kThresholdOfError * options.error * kLevels[cursor.level] * cursor.threshold;
}

Next after_sweep(Cursor& cursor, const SolveOptions& options, const SweepOutcome& sweep) {
  const std::uint64_t limit = options.iterations;
  // Where iterations are counted out, each level gets its share of them.
  const std::uint64_t share = limit ? std::max<std::uint64_t>(1, limit / kLevels.size()) : 0;
  const bool last = at_last_level(cursor);
  // Light that goes round between white walls changes by little in a sweep, however much of it is
  // missing: the coarse system knows.
  const double by_sweeps = rest_of_light(cursor, sweep.change);
  cursor.rest = std::max(by_sweeps, sweep.awaited);
  ++cursor.sweep;
  cursor.last_change = sweep.change;
  // What the coarse system adds after a level's first sweep is seen after its second.
  cursor.unseen = cursor.sweep <= 2 ? 1 : cursor.unseen + sweep.change;
  const bool no_progress = stalled(cursor, sweep);
  if (cursor.settling) ++cursor.settling;
  const bool is_settled = settled(cursor, options, by_sweeps);
  if (last && options.residual > 0 && sweep.residual <= options.residual)
    return end_for_good(cursor, Stop::kResidual);
  if (limit && cursor.iteration >= limit) return {.stop = Stop::kIterations};
  if (options.residual == 0 &&
      (cursor.settling > kMostSettling ||
       (last || cursor.settling ? is_settled || no_progress : is_settled && !limit))) {
    cursor.phase = Phase::kJudge;
    return {};
  }
  if (last && no_progress) return end_for_good(cursor, Stop::kStalled);
  if (!last && (is_settled || (share && cursor.sweep >= share))) return begin_level(cursor, 1);
  return {};
}

// A coarse level's answer is taken where that is beyond doubt.
Next after_estimate(Cursor& cursor, const SolveOptions& options, const ErrorEstimate& estimate,
                    std::uint64_t links) {
  const double asked = options.error, found = estimate.error;
  const bool last = at_last_level(cursor), finest = last && cursor.threshold <= 1;
  const bool few = links < kFewLinks;
  if ((last ? found : kBeyondDoubt * estimate.high) <= asked && cursor.level >= kFirstTaken)
    return take(cursor, options);
  const bool will_do = found <= kMendedByPass * asked && (finest || !few);
  const bool no_finer = finest && cursor.tightened == kMostTightened;
  if (!cursor.mended && last && (will_do || no_finer)) {
    cursor.phase = Phase::kMeasure;
    return {};
  }
  return make_finer(cursor, std::clamp(squared(asked / found), kTightest, kLoosest));
}

// Where what is known of the error is stale; where it is to be judged, until it is clear.
bool needs_look(std::size_t look, const Cursor& cursor, const SolveOptions& options,
                const ErrorEstimate& known, std::uint64_t links) {
  const bool judged = cursor.phase == Phase::kJudge, few = links < kFewLinks;
  const bool last = at_last_level(cursor);
  if (look == 0 && (!few || (judged && last))) return false;
  const bool stale =
      known.points == 0 || cursor.unseen >= (judged ? kStaleToJudge : kStale) * known.error;
  const bool closer = known.points < static_cast<std::uint64_t>(kLooks[look].points);
  const bool open = judged && (last || !few) && known.low <= options.error &&
                    options.error < known.high && closer;
  const bool vague = known.high > kVague * known.low && closer && look + 1 < kLooks.size();
  return stale || open || vague;
}

}  // namespace atrium
