// The page of `atrium report`: one or several runs side by side, in figures and tables.
#pragma once

#include <string>
#include <vector>

#include "apps/report/run_data.h"
#include "apps/report/run_interactions.h"

namespace atrium {

// What a run is called on the page: the last part of its directory's path; where two would be
// called alike, as they were named on the command line.
std::vector<std::string> names_of(const std::vector<RunData>& runs);

// A whole HTML page. Equal runs give equal bytes. At least one run; of each its interactions too.
std::string report_page(const std::vector<RunData>& runs,
                        const std::vector<RunInteractions>& interactions);

}  // namespace atrium
