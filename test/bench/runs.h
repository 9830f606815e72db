// Runs as their texts would tell of them.
#pragma once

#include "apps/report/run_data.h"

namespace atrium::testing {

// A complete iteration of four clusters.
inline HistoryEntry iteration(double number, double seconds, double working_set) {
  HistoryEntry e;
  e.iteration = number;
  e.clusters_gathered = 4;
  e.seconds = seconds;
  e.elements = 100 * number;
  e.links = 1000 * number;
  e.max_working_set_bytes = working_set;
  e.solver_seconds = 1.5;
  e.io_seconds = .5;
  e.reads = 10 * number;
  e.bytes_read = 2e6 * number;
  e.hit_ratio = .75;
  return e;
}

// Two iterations; the first took 3 s with all that comes before it, the second 2 s.
inline RunData two_iterations() {
  RunData run;
  run.history = {iteration(1, 3, 7e6), iteration(2, 5, 4e6)};
  run.history[0].largest_working_sets = {5e6, 7e6};
  run.history[0].mean_working_sets = {4e6, 3e6};
  run.history[1].largest_working_sets = {4e6, 1e6};
  run.history[1].mean_working_sets = {4e6, 1e6};
  RunSummary s;
  s.clusters = 4;
  s.elements = 200;
  s.links = 2000;
  s.max_working_set_bytes = 7e6;
  s.max_working_set_links = 900;
  s.max_working_set_elements = 90;
  s.total_data_bytes = 30e6;
  s.solver_seconds = 3;
  s.io_seconds = 1;
  s.total_seconds = 6;
  run.summary = s;
  return run;
}

}  // namespace atrium::testing
