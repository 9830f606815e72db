// The tables of the report, runs beneath each other: pieces of HTML, each a section with its
// heading unless it says otherwise. What a run does not know is a dash, or a sentence.
#pragma once

#include <string>
#include <vector>

#include "apps/report/run_figures.h"

namespace atrium {

using ShownRuns = std::vector<ShownRun>;

std::string scene_names(const RunData& run);  // files, without folders; "" where run.toml has none

std::string runs_table(const ShownRuns& runs);     // scene, end, program; no heading
std::string options_table(const ShownRuns& runs);  // no heading
std::string figures_section(const ShownRuns& runs);
std::string energy_section(const ShownRuns& runs);
std::string memory_section(const ShownRuns& runs);
std::string transfer_section(const ShownRuns& runs);
std::string left_out_section(const ShownRuns& runs);
std::string history_section(const ShownRuns& runs);  // all lines, to unfold

std::string table_style();

}  // namespace atrium
