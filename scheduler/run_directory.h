// RunDirectory: a solve's directory while the solve goes on: the page store, the texts beside it,
// the status page, and the trace of what is asked of the store.
//
//   open            the directory is there and says so: from here on the run can be resumed
//   reopen          with the run's own arena, once the plan knows it
//   checkpoint      all of it durable, together with the solve's own state
//
// Invariants:
//  1. Of what a directory holds, nothing is used that does not match the sums of its last
//     checkpoint; another run's directory is refused, unless nothing was begun in it.
//  2. One process works in it: the store holds its lock.
// Not thread safe. Errors: kStore the disk and what is on it, kUsage another run's directory.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "pagestore/cluster_store.h"
#include "pagestore/trace_writer.h"
#include "scheduler/run_files.h"
#include "scheduler/run_state.h"
#include "scheduler/solve.h"
#include "scheduler/status_page.h"

namespace atrium {

class RunDirectory {
 public:
  RunDirectory(const SolveOptions& options, const LogCallback& log);

  Status open();
  Status reopen(std::size_t arena);
  // The state that this process goes on from; not begun where the run is new.
  const RunState& earlier() const { return earlier_; }

  // Is the disk large enough? Before starting, and not after hours.
  Status see_to_disk(const Plan& plan) const;

  // Fills in the sums of the texts. summary_is_of_now: else the state knows no summary, for one is
  // about to be written in the place of an earlier run's.
  Status checkpoint(RunState state, bool summary_is_of_now);

  // What was recorded before a stop stays: each part of a run that is resumed has a trace of its
  // own. One that cannot be written ends early, and the solve goes on: it is what was asked for.
  Status begin_trace();
  void mark_iteration(std::uint64_t number);
  void mark_gather(RecordId receiver);
  void end_trace();

  Status write_status(const RunStatus& status) { return page_->write(status); }
  ClusterStore& store() { return *store_; }
  const ClusterStore& store() const { return *store_; }
  RunFiles& files() { return files_; }

 private:
  StoreOptions store_options(std::size_t arena) const;
  Status open_store(std::size_t arena);
  Status create_store();
  Status become_this_run();
  void say(const std::string& text) const {
    if (log_) log_(text);
  }

  const SolveOptions& options_;
  const LogCallback& log_;
  Disk& disk_;  // of the texts; the store has its own way to the machine's
  RunFiles files_;
  std::optional<StatusPage> page_;
  std::unique_ptr<TraceWriter> trace_;  // null: nothing is recorded
  std::unique_ptr<ClusterStore> store_;
  RunState earlier_;
};

}  // namespace atrium
