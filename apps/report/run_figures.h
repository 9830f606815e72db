// The charts of the report: what each run's history gives along time and along iterations.
#pragma once

#include <string>
#include <vector>

#include "apps/report/chart.h"
#include "apps/report/run_data.h"

namespace atrium {

// A run on the page; its place in the list is its style.
struct ShownRun {
  std::string name;
  const RunData* data;
  std::vector<HistoryEntry> iterations;  // complete ones
};

// A chart, and in words what is not in it and why; the chart may be empty of points.
struct RunFigure {
  Chart chart;
  std::vector<std::string> notes;
  bool estimates = false, truths = false;  // of errors: which of the two it shows
};

enum class Clock { kWall, kCpu };

// From run.toml; none where that has none.
Figure error_asked(const RunData& run);

RunFigure error_figure(const std::vector<ShownRun>& runs, Clock clock);
RunFigure residual_figure(const std::vector<ShownRun>& runs);
RunFigure size_figure(const std::vector<ShownRun>& runs);  // elements and links
RunFigure hit_figure(const std::vector<ShownRun>& runs);
RunFigure working_set_figure(const std::vector<ShownRun>& runs);

// The names of the runs for which `lacks` holds.
template <class Lacks>
std::vector<std::string> names_where(const std::vector<ShownRun>& runs, Lacks lacks) {
  std::vector<std::string> names;
  for (const ShownRun& r : runs)
    if (lacks(r)) names.push_back(r.name);
  return names;
}
// "a", "a and b", "a, b and c"
std::string listed_names(const std::vector<std::string>& names);

}  // namespace atrium
