#include "apps/report/run_figures.h"

#include <algorithm>

#include "apps/report/number_text.h"
#include "engine/quantity.h"

namespace atrium {
namespace {

constexpr double kMega = 1e6;

struct Curve {
  Figure HistoryEntry::*x;
  Figure HistoryEntry::*y;
};

std::vector<Vec2> points_of(const std::vector<HistoryEntry>& entries, const Curve& curve,
                            double unit = 1) {
  std::vector<Vec2> points;
  for (const HistoryEntry& e : entries)
    if (e.*curve.x && e.*curve.y) points.push_back({*(e.*curve.x), *(e.*curve.y) / unit});
  return points;
}

std::vector<BandPoint> interval_of(const std::vector<HistoryEntry>& entries,
                                   Figure HistoryEntry::*x) {
  std::vector<BandPoint> band;
  for (const HistoryEntry& e : entries)
    if (e.*x && e.error_estimate && e.error_estimate_low && e.error_estimate_high)
      band.push_back({*(e.*x), *e.error_estimate_low, *e.error_estimate_high});
  return band;
}

// Where one run stands alone its lines are named by what they are, else by whose they are.
void name_ends(std::size_t runs, const char* what, const std::string& run, Series& series) {
  series.name = runs == 1 ? what : run + ", " + what;
  series.end_name = runs == 1 ? what : run;
}

// A line for each error that was asked for.
std::vector<Level> levels_asked(const std::vector<ShownRun>& runs) {
  std::vector<Level> levels;
  for (const ShownRun& r : runs) {
    const Figure asked = error_asked(*r.data);
    const auto same = [&](const Level& level) { return level.y == *asked; };
    if (asked && std::none_of(levels.begin(), levels.end(), same))
      levels.push_back({*asked, percent_text(*asked) + " asked"});
  }
  return levels;
}

// "a and b: <what>."
void note(const std::vector<std::string>& names, const std::string& what, RunFigure& figure) {
  if (!names.empty()) figure.notes.push_back(listed_names(names) + ": " + what + ".");
}

bool any(const std::vector<HistoryEntry>& entries, Figure HistoryEntry::*field) {
  return std::any_of(entries.begin(), entries.end(),
                     [&](const HistoryEntry& e) { return (e.*field).has_value(); });
}

bool has_reference(const RunData& run) {
  return std::any_of(run.options.begin(), run.options.end(),
                     [](const Setting& s) { return s.table.empty() && s.key == "reference"; });
}

// One curve a run, by iteration.
RunFigure by_iteration(const std::vector<ShownRun>& runs, const char* title, const Axis& y,
                       Figure HistoryEntry::*field, double unit = 1) {
  RunFigure figure;
  figure.chart.title = title;
  figure.chart.x = {"iteration", Scale::kLinear, TickText::kWhole, {}};
  figure.chart.y = y;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Series s;
    s.name = runs[i].name;
    if (runs.size() > 1) s.end_name = runs[i].name;
    s.style = static_cast<int>(i);
    s.points = points_of(runs[i].iterations, {&HistoryEntry::iteration, field}, unit);
    figure.chart.series.push_back(std::move(s));
  }
  note(names_where(runs, [&](const ShownRun& r) { return !any(r.iterations, field); }),
       "not in the history", figure);
  return figure;
}

}  // namespace

std::string listed_names(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " and " : ", ") + names[i];
  return text;
}

Figure error_asked(const RunData& run) {
  for (const Setting& s : run.options) {
    if (s.key != "error" || !s.table.empty() || s.values.size() != 1) continue;
    const Result<double> share = parse_share(s.values.front());
    if (share.ok() && *share > 0) return *share;
  }
  return std::nullopt;
}

RunFigure error_figure(const std::vector<ShownRun>& runs, Clock clock) {
  const bool wall = clock == Clock::kWall;
  const auto x = wall ? &HistoryEntry::seconds : &HistoryEntry::cpu_seconds;
  RunFigure figure;
  figure.chart.title = wall ? "Error against wall time" : "Error against CPU time";
  figure.chart.x = {wall ? "wall time, s" : "CPU time, s", Scale::kLog, TickText::kNumber, {}};
  figure.chart.y = {"error", Scale::kLog, TickText::kPercent, {}};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::vector<HistoryEntry>& history = runs[i].data->history;
    Series estimate, truth;
    name_ends(runs.size(), "estimate", runs[i].name, estimate);
    name_ends(runs.size(), "true", runs[i].name, truth);
    estimate.style = truth.style = static_cast<int>(i);
    estimate.marks = false;
    truth.stroke = Stroke::kDashed;
    estimate.points = points_of(history, {x, &HistoryEntry::error_estimate});
    estimate.band = interval_of(history, x);
    truth.points = points_of(history, {x, &HistoryEntry::error_true});
    figure.estimates |= !estimate.points.empty();
    figure.truths |= !truth.points.empty();
    // One name a run is enough.
    if (runs.size() > 1 && !estimate.points.empty()) truth.end_name.clear();
    figure.chart.series.push_back(std::move(estimate));
    figure.chart.series.push_back(std::move(truth));
  }
  figure.chart.levels = levels_asked(runs);
  const auto without_truth = [&](bool reference) {
    return names_where(runs, [=](const ShownRun& r) {
      return !any(r.data->history, &HistoryEntry::error_true) &&
             has_reference(*r.data) == reference;
    });
  };
  note(names_where(
           runs,
           [](const ShownRun& r) { return !any(r.data->history, &HistoryEntry::error_estimate); }),
       "no error estimate in the history", figure);
  note(without_truth(true), "no true error in the history yet", figure);
  note(without_truth(false), "no true error, for no reference was given", figure);
  return figure;
}

RunFigure residual_figure(const std::vector<ShownRun>& runs) {
  return by_iteration(runs, "Residual by iteration",
                      {"relative residual", Scale::kLog, TickText::kNumber, {}},
                      &HistoryEntry::residual);
}

RunFigure size_figure(const std::vector<ShownRun>& runs) {
  RunFigure figure =
      by_iteration(runs, "Elements and links by iteration",
                   {"elements, links", Scale::kLog, TickText::kCount, {}}, &HistoryEntry::elements);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    Series links;
    name_ends(runs.size(), "elements", runs[i].name, figure.chart.series[i]);
    name_ends(runs.size(), "links", runs[i].name, links);
    if (runs.size() > 1) links.end_name.clear();
    links.style = static_cast<int>(i);
    links.stroke = Stroke::kDashed;
    links.points = points_of(runs[i].iterations, {&HistoryEntry::iteration, &HistoryEntry::links});
    figure.chart.series.push_back(std::move(links));
  }
  return figure;
}

RunFigure hit_figure(const std::vector<ShownRun>& runs) {
  constexpr double kLeastShown = 0.9;  // so that a per mille is not a chasm
  return by_iteration(
      runs, "Hit ratio by iteration",
      {"page cache hits ÷ requests", Scale::kLinear, TickText::kPercent, {kLeastShown, 1}},
      &HistoryEntry::hit_ratio);
}

RunFigure working_set_figure(const std::vector<ShownRun>& runs) {
  return by_iteration(runs, "Largest working set by iteration",
                      {"largest working set, MB", Scale::kLog, TickText::kNumber, {}},
                      &HistoryEntry::max_working_set_bytes, kMega);
}

}  // namespace atrium
