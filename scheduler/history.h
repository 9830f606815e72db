// What stands in the files of a run (scheduler/run_files.h): run.toml (how to repeat it), a line of
// history.jsonl, summary.json. Formats as in the command line's contract.
#pragma once

#include <string>

#include "engine/status.h"
#include "scheduler/solve.h"

namespace atrium {

std::string history_json(const HistoryLine& line);
std::string summary_json(const SolveSummary& summary);
std::string run_toml(const SolveOptions& options);

std::string program_version();

}  // namespace atrium
