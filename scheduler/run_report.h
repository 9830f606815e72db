// RunReport: what a solve tells of itself while it goes on, and of its end: lines of the history
// and of the log, the status page, the progress line, the summary.
//
// Invariants:
//  1. Seconds and counts go on over all processes that worked on the run: what earlier ones counted
//     is part of a checkpoint.
//  2. Nothing here has an effect on the solution.
// Not thread safe. Errors: kStore the disk.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/status.h"
#include "engine/stopwatch.h"
#include "pagestore/cluster_store.h"
#include "scheduler/plan.h"
#include "scheduler/run_directory.h"
#include "scheduler/run_state.h"
#include "scheduler/solve.h"
#include "visibility/gap_words.h"

namespace atrium {

class RunReport {
 public:
  RunReport(RunDirectory& directory, const ProgressCallback& progress, const LogCallback& log);

  SolveSummary& summary() { return summary_; }
  double process_seconds() const { return now() - start_; }  // of this process alone

  void say(const std::string& text) const;  // to the caller
  Status log(const std::string& text);      // and to the run's log
  Status log_gaps(const std::vector<NamedGap>& gaps);
  Status log_links(const LinksKept& kept);

  // What is to be solved, once it is known.
  void begin(const Prepared& prepared);
  // What earlier processes counted.
  void take_up(const RunState& earlier);
  // A checkpoint is about to be taken, and counts itself; it has been taken.
  void count_checkpoint(RunState& state);
  void checkpointed() { checkpoint_at_ = seconds(); }

  // So many clusters an iteration.
  void gathers_to(std::uint64_t clusters) { gathers_to_ = clusters; }
  void begin_sweep() { sweep_began_ = counters(); }
  void end_sweep(const Sweep& sweep);
  // Of a sweep across links.
  void count_links(const Sweep& sweep, double residual);

  // The status page, and the progress line: now and then, or at once.
  Status show(const Cursor& cursor, const Sweep& sweep, bool at_once);

  // An iteration goes on for so long that the history wants a line of it.
  bool line_due() const;
  // What is known of an iteration, complete or not, but for its errors.
  HistoryLine line(const Cursor& cursor, const Sweep& sweep, bool complete) const;
  Status record(const HistoryLine& line, std::uint32_t level, bool complete);

  Status write_summary();

 private:
  double seconds() const { return directory_.earlier().seconds + process_seconds(); }
  double cpu_seconds() const;
  StoreCounters counters() const {
    return directory_.earlier().counters + directory_.store().counters();
  }
  bool ended() const { return !summary_.stop_reason.empty(); }

  RunDirectory& directory_;
  const ProgressCallback& progress_;
  const LogCallback& log_;
  const double start_, cpu_start_;
  std::uint64_t gathers_to_ = 0;
  StoreCounters sweep_began_;
  SolveSummary summary_;
  HistoryLine last_line_;
  double last_shown_ = 0, last_line_at_ = now();
  double checkpoint_at_ = -1;  // s from the start; -1: none yet
};

}  // namespace atrium
