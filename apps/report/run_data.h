// What a run directory's texts tell of the run: run.toml, history.jsonl, summary.json. The page
// store is not looked at, so that texts that were copied from elsewhere will do.
//
// Invariants:
//  1. What stands there is read strictly: what is no JSON, or of another kind than the field's, is
//     kStore and names file and line. What is not there is not there: older runs lack fields, runs
//     that are still going have no summary. A line that is being written, or that a crash cut
//     short, ends the history.
//  2. History only goes forward: where a run went on from a checkpoint, what it had done after that
//     and did again is left out. So a run is one series however often it was resumed.
//  3. A summary that the history has outgrown, or of a run that is being solved, is none.
// Plain data; no thread safety of its own.
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/run_look.h"
#include "apps/settings_file.h"
#include "engine/status.h"
#include "scheduler/solve.h"

namespace atrium {

using Figure = std::optional<double>;

// A line of history.jsonl; units as there (s, bytes, shares of 1).
struct HistoryEntry {
  Figure seconds, cpu_seconds, iteration, clusters_gathered, residual;
  Figure error_estimate, error_estimate_low, error_estimate_high, error_true, energy_closure;
  Figure elements, links, rays, reads, writes, bytes_read, bytes_written, hit_ratio;
  Figure solver_seconds, io_seconds, stall_seconds, max_working_set_bytes, peak_rss_bytes;
  // In the course of the iteration, a figure a step; empty where its line has none.
  std::vector<double> largest_working_sets, mean_working_sets;  // bytes
};

struct RunSummary {
  Figure patches, clusters, cells, portals, lights, iterations, elements, links;
  Figure max_working_set_bytes, max_working_set_links, max_working_set_elements;
  Figure links_processed, total_data_bytes, store_bytes;
  Figure flux_emitted, flux_absorbed, flux_escaped;  // lm
  Figure hit_ratio, reads, writes, evictions, bytes_read, bytes_written;
  Figure solver_seconds, io_seconds, stall_seconds, total_seconds;
  Figure residual, error_estimate, error_estimate_low, error_estimate_high, error_true;
  Figure energy_closure, exit_code, peak_rss_bytes;
  std::string stop_reason, version;
  std::vector<LeftOut> left_out;
};

// A number of a record: its key in the file, and where it is kept.
template <class Record>
struct Field {
  const char* name;
  Figure Record::*value;
  double least = 0;
};

std::span<const Field<HistoryEntry>> history_fields();

struct RunData {
  std::string directory;                 // as it was named
  RunLife life = RunLife::kInterrupted;  // kSolving while a process works on it
  std::vector<Setting> options;          // run.toml
  std::vector<HistoryEntry> history;
  std::optional<RunSummary> summary;
};

// `path` stands in errors.
Result<std::vector<HistoryEntry>> parse_history(const std::string& text, const std::string& path);
Result<RunSummary> parse_summary(const std::string& text, const std::string& path);

// kUsage: it is no run directory. kStore: its texts are broken.
Result<RunData> read_run(const std::string& directory);

// One entry an iteration, the last of it. One that did not reach all clusters is left out.
std::vector<HistoryEntry> complete_iterations(const RunData& run);

}  // namespace atrium
