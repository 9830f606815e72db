// RunState: what a checkpoint holds beside the records, so that a solve goes on as if it had never
// been stopped: where in the iteration it stands, the sums of the sweep it is in, what the summary
// has counted, and the sums of the run's texts. Taken between two gathers. Plain bytes, as the page
// store's state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/gather_cluster.h"
#include "scheduler/run_files.h"
#include "scheduler/solve.h"

namespace atrium {

// What a sweep over the clusters does.
enum class Phase : std::uint32_t {
  kLinks,    // gathers across links
  kMeasure,  // a local pass (scheduler/local_pass.h): measures
  kMend,     // and mends
  kJudge     // no sweep: the error is estimated, and what comes next decided
};

// Where the iteration stands.
struct Cursor {
  std::uint64_t iteration = 0;  // complete gathers to all clusters
  std::uint32_t level = 0;
  std::uint32_t sweep = 0;      // in this level
  double mean_irradiance = 0;   // lx
  double mean_radiosity = 0;    // lm/m²
  double last_change = 0;
  std::uint32_t done = 0;       // how the run ended, where going on would not change that
  double unseen = 0;            // Σ changes since the error was last estimated
  Phase phase = Phase::kLinks;
  double threshold = 1;         // of links, times what the error asked for sets
  std::uint32_t mended = 0;     // 1: by a local pass, since the links were made
  std::uint32_t tightened = 0;  // times that the estimate asked for finer links
  double residual = 0;          // of the last sweep across links
  std::uint32_t stalled = 0;    // sweeps in a row whose change did not fall
  double least_change = 0;      // of this level
  double rest = 1;              // of the light, what is still to come
  std::uint32_t settling = 0;   // sweeps, and one, since it was exact enough but for that rest
  std::uint32_t to_mend = 0;    // 1: by a local pass, before it is judged
  std::uint32_t divided = 1;    // 1: large patches are, where it pays (scheduler/coarse_units.h)
};

// Working sets in the course of an iteration, in steps of as many gathers each: a bounded number of
// figures, whatever the scene. [THFH94 figure 4]
struct WorkingSetCourse {
  static constexpr std::size_t kMostSteps = 200;
  std::array<std::uint64_t, kMostSteps> largest{}, sum{}, gathers{};  // bytes; of bytes; counted

  // The gather number `gathered` (from 0) of `all`.
  void add(std::uint64_t gathered, std::uint64_t all, std::uint64_t bytes);
};

// Sums over an iteration.
struct Sweep {
  PushPullSums sums;
  RefineCounters refined;
  std::uint64_t gathered = 0, elements = 0, links = 0;
  std::uint64_t working_set_bytes = 0, working_set_links = 0, working_set_elements = 0;
  std::uint64_t total_bytes = 0;
  double solver_seconds = 0;
  WorkingSetCourse working_sets;

  // One of the gathers to all `clusters`.
  void add(const GatherReport& r, std::uint64_t clusters);
};

// One more with every change of RunState, or of the records beside it that a run goes on from.
inline constexpr std::uint32_t kRunStateVersion = 19;

struct RunState {
  std::uint32_t version = kRunStateVersion;
  std::uint32_t begun = 0;       // 1: the first records are there
  std::uint64_t model_hash = 0;  // of the model record
  double error_asked = 0;
  Cursor cursor;
  Sweep sweep;
  SolveFigures figures;
  StoreCounters counters, sweep_began;  // over all processes; at the sweep's begin
  double seconds = 0, cpu_seconds = 0;
  RunSums sums;
};

std::span<const std::byte> to_bytes(const RunState& state);
// kStore: not a state of this version of the program.
Result<RunState> run_state(std::span<const std::byte> bytes, const std::string& directory);

}  // namespace atrium
