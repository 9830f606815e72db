// The options that plan, solve and resume share, and what solve and resume do with them.
#pragma once

#include "apps/command.h"
#include "scheduler/solve.h"

namespace atrium {

inline constexpr std::size_t kMostFiles = 4096;  // of one scene

void add_solve_options(OptionSet& options, SolveOptions& solve);

// The options that a run was begun with, from its run.toml; those that it does not name are as they
// are by default. kStore, with the line, where it is not as a run writes it; kUsage where the run
// is another version's.
Status read_run_toml(const std::string& path, SolveOptions& options);

// Solves, hears the signals meanwhile, and tells what came of it: the exit code.
Result<int> run_solve(const SolveOptions& options, const Global& global, Console& console);

}  // namespace atrium
