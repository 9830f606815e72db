// The files a run leaves for people and other programs beside its page store: run.toml (how to
// repeat it), history.jsonl (a line an iteration), summary.json, run.log. Formats as in the
// command line's contract.
#pragma once

#include <string>

#include "engine/status.h"
#include "scheduler/solve.h"

namespace atrium {

std::string history_json(const HistoryLine& line);
std::string summary_json(const SolveSummary& summary);
std::string run_toml(const SolveOptions& options);

Status write_text(const std::string& path, const std::string& text);
Status append_line(const std::string& path, const std::string& line);
Result<std::string> read_text(const std::string& path);

std::string program_version();

}  // namespace atrium
