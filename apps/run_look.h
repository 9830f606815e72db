// A look at a run from another process: who holds its lock, and its status page. [status, stop]
#pragma once

#include <optional>
#include <string>

#include "engine/status.h"
#include "scheduler/status_page.h"

namespace atrium {

enum class RunLife {
  kPreparing,   // live: import, partition
  kSolving,     // live
  kEnded,       // as it meant to
  kInterrupted  // nobody works on it, and it did not say that it was done
};

struct RunLook {
  RunLife life = RunLife::kInterrupted;
  std::optional<long> process;    // that works on it
  std::optional<RunStatus> page;  // as it last told; none before it first did
  std::string stop_reason;        // of an ended run
};

std::string to_string(RunLife life);

inline std::string lock_path(const std::string& run) { return run + "/lock"; }

// kUsage: it is no run directory. kStore: what it tells is damaged.
Result<RunLook> look_at_run(const std::string& run);

// s of solving after the last checkpoint; none before the first.
std::optional<double> seconds_since_checkpoint(const RunStatus& status);

}  // namespace atrium
