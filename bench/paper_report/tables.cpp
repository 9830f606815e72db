#include "bench/paper_report/tables.h"

#include <algorithm>

#include "apps/report/number_text.h"
#include "apps/report/run_figures.h"

namespace atrium {
namespace {

constexpr double kHour = 3600, kPercent = .01;
constexpr const char *kPaper = "paper", *kOurs = "ours";

using Row = std::vector<Entry>;

Row model_row(const ModelFigures& m, const char* whose) {
  return {word_entry(m.model),
          word_entry(whose),
          number_entry(m.clusters),
          number_entry(m.patches),
          number_entry(m.lights),
          number_entry(m.set_mb, 1),
          number_entry(m.total_mb, 1),
          number_entry(m.set_links),
          number_entry(m.links),
          number_entry(m.links_a_patch),
          number_entry(m.set_elements),
          number_entry(m.elements),
          number_entry(m.elements_a_patch, 1),
          number_entry(m.seconds, whose == kPaper ? 0 : 2),
          number_entry(m.seconds_a_patch, whose == kPaper ? 1 : 5)};
}

Row order_row(const OrderFigures& o, const char* whose) {
  const int decimals = whose == kPaper ? 0 : 2;
  return {word_entry(o.order),
          word_entry(whose),
          number_entry(o.reads),
          number_entry(o.read_mb, whose == kPaper ? 0 : 1),
          number_entry(o.hit_ratio, 1, kPercent, "%"),
          number_entry(o.io_seconds, decimals),
          number_entry(o.seconds, decimals)};
}

Row iteration_row(const IterationFigures& i, const char* whose) {
  const auto time = [&](const Figure& seconds) {
    return whose == kPaper ? number_entry(seconds, 1, kHour, " h")
                           : number_entry(seconds, 2, 1, " s");
  };
  return {i.iteration ? number_entry(i.iteration) : word_entry("Total"),
          word_entry(whose),
          number_entry(i.elements),
          number_entry(i.links),
          number_entry(i.set_mb, 1),
          time(i.solver_seconds),
          time(i.io_seconds),
          time(i.seconds)};
}

// Three counts in one column.
std::string counts(const ModelFigures& m) {
  const auto text = [](const Figure& f) { return f ? whole_text(*f) : std::string("–"); };
  return text(m.clusters) + " / " + text(m.patches) + " / " + text(m.lights);
}

}  // namespace

TextTable models_table(std::span<const std::string> names, std::span<const SolvedModel> ours) {
  TextTable table;
  table.columns = {{"Model", "model"},
                   {"", "whose"},
                   {"Clusters", "clusters"},
                   {"Patches", "patches"},
                   {"Lights", "lights"},
                   {"Working Set (MB): WS", "working_set_mb"},
                   {"Total", "total_mb"},
                   {"# Links: WS", "working_set_links"},
                   {"Total", "links"},
                   {"/ Patch", "links_a_patch"},
                   {"# Elements: WS", "working_set_elements"},
                   {"Total", "elements"},
                   {"/ Patch", "elements_a_patch"},
                   {"Elapsed Time (s): Total", "seconds"},
                   {"/ Patch", "seconds_a_patch"}};
  for (const std::string& name : names) {
    const auto found =
        std::ranges::find_if(ours, [&](const SolvedModel& m) { return m.figures.model == name; });
    if (found == ours.end()) continue;
    for (const ModelFigures& paper : paper_models())
      if (paper.model == name) table.rows.push_back(model_row(paper, kPaper));
    table.rows.push_back(model_row(found->figures, kOurs));
  }
  return table;
}

TextTable orders_table(std::span<const OrderFigures> ours) {
  TextTable table;
  table.columns = {{"Order", "order"},
                   {"", "whose"},
                   {"Clusters Read", "reads"},
                   {"MB Read", "read_mb"},
                   {"Cache Hit Ratio", "hit_ratio"},
                   {"I/O Time (s)", "io_seconds"},
                   {"Total Time (s)", "seconds"}};
  const auto in_paper = [](const OrderFigures& o) {
    return std::ranges::any_of(paper_orders(),
                               [&](const OrderFigures& p) { return p.order == o.order; });
  };
  for (const OrderFigures& paper : paper_orders())
    for (const OrderFigures& own : ours)
      if (own.order == paper.order) {
        table.rows.push_back(order_row(paper, kPaper));
        table.rows.push_back(order_row(own, kOurs));
      }
  for (const OrderFigures& own : ours)
    if (!in_paper(own)) table.rows.push_back(order_row(own, kOurs));
  return table;
}

TextTable iterations_table(std::span<const IterationFigures> ours) {
  TextTable table;
  table.columns = {{"# Iter", "iteration"},           {"", "whose"},
                   {"# Elements", "elements"},        {"# Links", "links"},
                   {"Max WS (MB)", "working_set_mb"}, {"Solver Time", "solver_seconds"},
                   {"I/O Time", "io_seconds"},        {"Total Time", "seconds"}};
  for (const IterationFigures& own : ours) {
    for (const IterationFigures& paper : paper_iterations())
      if (paper.iteration == own.iteration) table.rows.push_back(iteration_row(paper, kPaper));
    table.rows.push_back(iteration_row(own, kOurs));
  }
  return table;
}

TextTable results_table(std::span<const SolvedModel> ours) {
  TextTable table;
  table.columns = {{"model", "model"},
                   {"clusters / patches / lights", "clusters_patches_lights"},
                   {"error asked", "error_asked"},
                   {"estimated", "error_estimate"},
                   {"true", "error_true"},
                   {"elements", "elements"},
                   {"links", "links"},
                   {"largest working set", "working_set_mb"},
                   {"all data", "total_mb"},
                   {"stalled on I/O", "stall_seconds"},
                   {"CPU", "cpu_seconds"},
                   {"time", "seconds"}};
  for (const SolvedModel& m : ours) {
    const RunSummary none;
    const RunSummary& s = m.run.summary ? *m.run.summary : none;
    const Figure cpu = m.run.history.empty() ? Figure() : m.run.history.back().cpu_seconds;
    table.rows.push_back(
        {word_entry(m.figures.model), word_entry(counts(m.figures)),
         number_entry(error_asked(m.run), 0, kPercent, "%"),
         number_entry(s.error_estimate, 1, kPercent, "%"),
         number_entry(s.error_true, 1, kPercent, "%"), number_entry(m.figures.elements),
         number_entry(m.figures.links), number_entry(m.figures.set_mb, 1, 1, " MB"),
         number_entry(m.figures.total_mb, 0, 1, " MB"), number_entry(s.stall_seconds, 2, 1, " s"),
         number_entry(cpu, 1, 1, " s"), number_entry(m.figures.seconds, 1, 1, " s")});
  }
  return table;
}

}  // namespace atrium
