// The main job: import, partition, order, and the iteration over complete gathers until the
// solution is as exact as asked or a limit is reached. [THFH94 §4, the radiosity scheduler]
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/import/import.h"
#include "engine/status.h"
#include "scheduler/error_estimate.h"
#include "scheduler/kept_links.h"
#include "solver/refine_counters.h"
#include "visibility/gap_words.h"
#include "visibility/partition.h"

namespace atrium {

class Disk;

struct SolveOptions {
  ImportOptions scene;
  PartitionOptions partition;
  std::string run_directory;
  std::uint64_t memory = 512ull << 20;  // bytes, of everything that depends on the scene
  std::uint64_t arena = 0;              // bytes of page cache; 0: a share of memory
  double error = 0.02;                  // the error asked for
  double residual = 0;                  // relative; 0: not asked for
  std::uint64_t iterations = 0;         // complete gathers at most; 0: no limit
  double time_limit = 0;                // s; 0: none
  double min_edge = 0;                  // m; 0: by the scene
  std::string order = "cell";           // scheduler/order.h
  std::string policy = "lru";
  int basis = 2;
  std::string links = "auto";  // keep, discard, auto
  std::uint64_t seed = 1;
  int threads = 0;  // 0: all
  std::string reference;  // points with known irradiance; empty: none
  std::vector<std::string> force;
  std::string io = "mmap";        // mmap, direct
  double checkpoint_every = 600;  // s
  std::string trace;              // the store's accesses are recorded here; empty: nowhere
  std::string from;               // the run to start from (scheduler/warm_start.h); empty: none
  // From here on nothing that repeats a run.
  bool recover = false;  // where the newest root does not verify, go on from the older one
  Disk* disk = nullptr;  // nullptr: the machine's own
};

// In the course of an iteration, in steps of as many gathers each.
struct WorkingSetSteps {
  std::vector<std::uint64_t> largest, mean;  // bytes, a figure a step
};

// A line of history.jsonl, figures of that iteration.
struct HistoryLine {
  double seconds = 0, cpu_seconds = 0;
  std::uint64_t iteration = 0, clusters_gathered = 0;
  double residual = 0;
  ErrorEstimate estimate;
  double error_true = -1;  // -1: no reference
  std::uint64_t elements = 0, links = 0, rays = 0;
  std::uint64_t reads = 0, writes = 0, bytes_read = 0, bytes_written = 0;
  double hit_ratio = 0;
  double solver_seconds = 0, io_seconds = 0, stall_seconds = 0;
  std::uint64_t max_working_set_bytes = 0, peak_rss_bytes = 0;
  WorkingSetSteps working_sets;  // of a complete sweep across links; else empty
};

struct LeftOut {
  std::string feature, why;
};

// What a solve took over from the run that it started from.
struct WarmFigures {
  std::uint64_t patches_kept = 0, elements_kept = 0;
  std::uint64_t clusters_changed = 0;  // by the edit: in shape, paint, or what touches them
  std::uint64_t clusters_reached = 0;  // gathered to
};

// The figures of a summary; they are part of a checkpoint's state.
struct SolveFigures {
  std::uint64_t patches = 0, clusters = 0, cells = 0, portals = 0, lights = 0;
  std::uint64_t iterations = 0, elements = 0, links = 0;
  std::uint64_t max_working_set_bytes = 0, max_working_set_links = 0, max_working_set_elements = 0;
  std::uint64_t links_processed = 0, total_data_bytes = 0, store_bytes = 0;
  RefineCounters refined;                                        // over all iterations
  double flux_emitted = 0, flux_absorbed = 0, flux_escaped = 0;  // lm
  double hit_ratio = 0;
  std::uint64_t reads = 0, writes = 0, bytes_read = 0, bytes_written = 0, evictions = 0;
  double solver_seconds = 0, io_seconds = 0, stall_seconds = 0, total_seconds = 0;
  double residual = 0;
  ErrorEstimate estimate;
  double error_true = -1;  // -1: no reference
  std::uint64_t peak_rss_bytes = 0;
  std::uint64_t checkpoints = 0, resumes = 0;
  std::uint64_t live_bytes = 0, allocated_bytes = 0;  // of all records; of extents on disk
  std::uint64_t reads_ahead = 0;  // of reads: begun before they were asked for
  std::uint64_t streamed_bytes_read = 0, streamed_bytes_written = 0;  // of links, past the arena
  WarmFigures warm;
  LinksKept links_kept;  // of the last level, when its links had been made
  std::uint64_t file_bytes = 0;  // of the page store's files
  double cpu_seconds = 0;
};

// What a solve will take, from counts and stated rates: within a factor of two or three.
struct CostEstimate {
  std::uint64_t elements = 0, links = 0;  // of the last level
  std::uint64_t memory_bytes = 0;         // resident, code and libraries included
  std::uint64_t disk_bytes = 0;           // of the page store's files
  double cpu_seconds = 0;
};

struct SolveSummary : SolveFigures {
  std::vector<std::string> scene;
  std::string from;  // the run that it started from; empty: none
  std::string stop_reason;
  int exit_code = 0;
  std::vector<LeftOut> left_out;
  CostEstimate estimated;
  int threads = 0;
};

// What solve would do with a scene; also the first thing it does.
struct Plan {
  std::uint64_t clusters = 0, patches = 0, cells = 0, portals = 0, rooms = 0, lights = 0;
  double visible_share = 0;           // pairs kept ÷ all pairs of clusters
  std::uint64_t memory = 0, arena = 0;        // bytes, as they will be used
  std::uint64_t smallest_memory = 0, smallest_arena = 0;  // that will do
  std::uint64_t smallest_disk = 0;  // bytes, without which it cannot begin
  CostEstimate estimated;
  double mean_irradiance_guess = 0;   // lx
  double min_edge = 0;                // m
  std::uint64_t dense = 0;  // small patches from which on a cluster has face groups
  std::vector<LeftOut> left_out;
  std::optional<WarmFigures> warm;  // with SolveOptions::from
  std::vector<NamedGap> closed_gaps;  // the widest first
  std::vector<std::string> warnings;
};

struct Progress {
  std::uint64_t iteration = 0, gathered = 0, clusters = 0, elements = 0, links = 0;
  double seconds = 0, residual = 0, eta_seconds = -1;  // eta of this iteration
};

// Called now and then between gathers.
using ProgressCallback = std::function<void(const Progress&)>;
using LogCallback = std::function<void(const std::string&)>;

Result<Plan> plan(const SolveOptions& options);

// Asks a running solve to finish its cluster, checkpoint and return with exit code 75. Safe in a
// signal handler.
void request_stop();
// Asks it to checkpoint and go on. Likewise.
void request_checkpoint();

// Errors: kUsage (options, budget too small), kScene, kStore. A limit that was reached is no error:
// exit_code 5 in the summary, the result kept.
Result<SolveSummary> solve(const SolveOptions& options, const ProgressCallback& progress,
                           const LogCallback& log);

}  // namespace atrium
