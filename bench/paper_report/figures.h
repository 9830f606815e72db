// The figures of the paper's Tables 2 to 5, in one shape for the paper's own, as printed, and for
// ours, from what a run's history and summary tell.
// Plain data and functions of it; no state.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/report/run_data.h"
#include "engine/import/inspect.h"

namespace atrium {

// A row of Tables 2 and 3. Bytes in MB, seconds by the wall. WS: the largest working set.
struct ModelFigures {
  std::string model;
  Figure clusters, patches, lights;  // of the input
  Figure set_mb, total_mb;
  Figure set_links, links, links_a_patch;
  Figure set_elements, elements, elements_a_patch;
  Figure seconds, seconds_a_patch;
};

// A row of Table 4.
struct OrderFigures {
  std::string order;
  Figure reads, read_mb, hit_ratio, io_seconds, seconds;
};

// A row of Table 5.
struct IterationFigures {
  Figure iteration;  // none: the last row, of all of them
  Figure elements, links, set_mb, solver_seconds, io_seconds, seconds;
};

struct SolvedModel {
  ModelFigures figures;
  RunData run;
};

// [THFH94, tables 2 to 5]
std::span<const ModelFigures> paper_models();
std::span<const OrderFigures> paper_orders();
std::span<const IterationFigures> paper_iterations();  // of Building; its last row is all of it
// The kinds of `atrium gen` that the paper's models are, in its order, and what it calls them.
std::vector<std::string> model_kinds();
std::string paper_name(const std::string& kind);

// Ours. A figure that the run does not tell is none.
ModelFigures model_figures(const std::string& model, const SceneReport& scene, const RunData& run);
// Of the last complete iteration.
OrderFigures order_figures(const std::string& order, const RunData& run);
// The input, each complete iteration, and all of it.
std::vector<IterationFigures> iteration_figures(const ModelFigures& model, const RunData& run);
// The complete iteration that had the largest working set and tells of it step by step.
std::optional<HistoryEntry> fullest_iteration(const RunData& run);
// Most seconds a patch ÷ fewest.
Figure spread_of_seconds_a_patch(std::span<const ModelFigures> models);

}  // namespace atrium
