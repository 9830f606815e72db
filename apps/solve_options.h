// The options that plan and solve share.
#pragma once

#include "apps/command.h"
#include "scheduler/solve.h"

namespace atrium {

inline constexpr std::size_t kMostFiles = 4096;  // of one scene

void add_solve_options(OptionSet& options, SolveOptions& solve);

}  // namespace atrium
