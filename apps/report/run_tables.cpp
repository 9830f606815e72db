#include "apps/report/run_tables.h"

#include <algorithm>

#include "apps/report/chart.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "apps/report/option_table.h"

namespace atrium {
namespace {

constexpr const char* kNone = "–";  // there is no such figure

using Row = std::vector<TableEntry>;

std::string run_swatch(std::size_t run) {
  constexpr Vec2 kMiddle{15, 6};
  const int style = static_cast<int>(run);
  return swatch_svg("hue" + std::to_string(style % kHues), Stroke::kSolid,
                    mark_svg(style, Stroke::kSolid, kMiddle));
}

TableEntry name_entry(const ShownRuns& runs, std::size_t i) {
  return {run_swatch(i) + html_text(runs[i].name)};
}

std::string version_of(const RunData& run) {
  for (const Setting& s : run.options)
    if (s.key == "version" && s.table.empty()) return option_text(s);
  return run.summary ? run.summary->version : "";
}

// Of the summary; of a run without one, as the last complete iteration that knows it has it.
Figure latest(const ShownRun& run, Figure RunSummary::*ended, Figure HistoryEntry::*going) {
  if (run.data->summary) return (*run.data->summary).*ended;
  const auto known = std::find_if(run.iterations.rbegin(), run.iterations.rend(),
                                  [&](const HistoryEntry& e) { return (e.*going).has_value(); });
  if (known == run.iterations.rend()) return std::nullopt;
  return *known.*going;
}

std::string shown(const Figure& figure, std::string (*text)(double)) {
  if (!figure) return kNone;
  return text(*figure);
}

std::string end_words(const RunData& run) {
  if (run.life == RunLife::kSolving) return "still being solved when this page was made";
  if (!run.summary) return "interrupted: it did not tell of an end";
  return run.summary->stop_reason.empty() ? "ended, without a reason" : run.summary->stop_reason;
}

// The error by which elements are judged: the true one where it is known.
Figure judged_error(const ShownRun& run) {
  const Figure truth = latest(run, &RunSummary::error_true, &HistoryEntry::error_true);
  return truth ? truth : latest(run, &RunSummary::error_estimate, &HistoryEntry::error_estimate);
}

std::string estimate_html(const ShownRun& run) {
  const auto of = [&](auto ended, auto going) { return latest(run, ended, going); };
  const Figure low = of(&RunSummary::error_estimate_low, &HistoryEntry::error_estimate_low);
  const Figure high = of(&RunSummary::error_estimate_high, &HistoryEntry::error_estimate_high);
  std::string html =
      shown(of(&RunSummary::error_estimate, &HistoryEntry::error_estimate), share_text);
  if (low && high)
    html +=
        "<br/><span class=\"small\">" + share_text(*low) + " to " + share_text(*high) + "</span>";
  return html;
}

Figure ratio(const Figure& a, const Figure& b) {
  if (!a || !b || *b == 0) return std::nullopt;
  return *a / *b;
}

Figure a_percent(const Figure& elements, const Figure& error) {
  constexpr double kPercent = 0.01;
  if (!elements || !error || *error == 0) return std::nullopt;
  return *elements * kPercent / *error;
}

// Over all lines, those that stand for a whole iteration or the last part of one.
Figure rays_of(const RunData& run) {
  Figure sum;
  for (std::size_t i = 0; i < run.history.size(); ++i) {
    const HistoryEntry& e = run.history[i];
    const bool goes_on = i + 1 < run.history.size() && run.history[i + 1].iteration == e.iteration;
    if (!goes_on && e.rays) sum = sum.value_or(0) + *e.rays;
  }
  return sum;
}

Figure peak_of(const RunData& run) {
  Figure peak;
  if (run.summary) peak = run.summary->peak_rss_bytes;
  for (const HistoryEntry& e : run.history) peak = std::max(peak, e.peak_rss_bytes);
  return peak;
}

Row figures_row(const ShownRuns& runs, std::size_t i) {
  const ShownRun& run = runs[i];
  const std::vector<HistoryEntry>& history = run.data->history;
  const auto of = [&](auto ended, auto going) { return latest(run, ended, going); };
  const Figure truth = of(&RunSummary::error_true, &HistoryEntry::error_true);
  const Figure estimate = of(&RunSummary::error_estimate, &HistoryEntry::error_estimate);
  const Figure elements = of(&RunSummary::elements, &HistoryEntry::elements);
  return {name_entry(runs, i),
          {shown(error_asked(*run.data), share_text)},
          {estimate_html(run)},
          {shown(truth, share_text)},
          {shown(ratio(estimate, truth), number_text)},
          {shown(elements, whole_text)},
          {shown(of(&RunSummary::links, &HistoryEntry::links), whole_text)},
          {shown(rays_of(*run.data), whole_text)},
          {shown(of(&RunSummary::iterations, &HistoryEntry::iteration), whole_text)},
          {shown(of(&RunSummary::total_seconds, &HistoryEntry::seconds), seconds_text)},
          {history.empty() ? kNone : shown(history.back().cpu_seconds, seconds_text)},
          {shown(peak_of(*run.data), megabytes_text)},
          {shown(of(&RunSummary::hit_ratio, &HistoryEntry::hit_ratio), share_text)},
          {shown(a_percent(elements, judged_error(run)), whole_text)}};
}

// Parts of what is emitted, as lengths.
std::string share_bar(double absorbed, double escaped, std::size_t run) {
  constexpr double kLength = 200, kHeight = 12;
  const double whole = std::max(1.0, absorbed + escaped);
  const auto bar = [&](const char* kind, double from, double length) {
    return "<rect class=\"" + std::string(kind) + "\" x=\"" +
           std::to_string(kLength * from / whole) + "\" y=\"0\" width=\"" +
           std::to_string(kLength * length / whole) + "\" height=\"" + std::to_string(kHeight) +
           "\"/>";
  };
  std::string svg = "<svg class=\"share hue" + std::to_string(run % kHues) +
                    "\" viewBox=\"0 0 200 12\" preserveAspectRatio=\"none\">" +
                    bar("absorbed", 0, std::max(0.0, absorbed)) +
                    bar("escaped", std::max(0.0, absorbed), std::max(0.0, escaped));
  const double missing = 1 - absorbed - escaped;
  if (missing > 0) svg += bar("missing", absorbed + escaped, missing);
  return svg + "</svg>";
}

std::string with_share(double flux, double emitted) {
  return number_text(flux) + " <span class=\"small\">" + share_text(flux / emitted) + "</span>";
}

Row energy_row(const ShownRuns& runs, std::size_t i) {
  const RunSummary& s = *runs[i].data->summary;
  const double emitted = *s.flux_emitted, absorbed = *s.flux_absorbed, escaped = *s.flux_escaped;
  return {name_entry(runs, i),
          {number_text(emitted)},
          {with_share(absorbed, emitted)},
          {with_share(escaped, emitted)},
          {with_share(emitted - absorbed - escaped, emitted)},
          {shown(s.energy_closure, signed_share_text)},
          {share_bar(absorbed / emitted, escaped / emitted, i)}};
}

struct Column {
  const char* head;
  Figure RunSummary::*value;
  std::string (*text)(double);
};

std::string summary_section(const char* heading, const ShownRuns& runs,
                            std::span<const Column> columns) {
  Table table{{"run"}, {}, false};
  for (const Column& c : columns) table.head.push_back(c.head);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].data->summary) continue;
    Row row{name_entry(runs, i)};
    for (const Column& c : columns)
      row.push_back({shown((*runs[i].data->summary).*c.value, c.text)});
    table.rows.push_back(std::move(row));
  }
  std::string html = html_heading(heading);
  if (!table.rows.empty()) html += html_table(table);
  const auto open = names_where(runs, [](const ShownRun& r) { return !r.data->summary; });
  if (!open.empty()) html += html_paragraph(html_text(listed_names(open)) + ": no summary yet.");
  return html;
}

std::string history_table(const RunData& run) {
  Table table;
  std::vector<const Field<HistoryEntry>*> fields;
  for (const Field<HistoryEntry>& f : history_fields()) {
    const bool there = std::any_of(run.history.begin(), run.history.end(),
                                   [&](const auto& e) { return (e.*f.value).has_value(); });
    if (there) fields.push_back(&f);
  }
  for (const auto* f : fields) table.head.push_back(f->name);
  for (const HistoryEntry& e : run.history) {
    Row row;
    for (const auto* f : fields) row.push_back({shown(e.*f->value, number_text)});
    table.rows.push_back(std::move(row));
  }
  return html_table(table);
}

}  // namespace

std::string scene_names(const RunData& run) {
  for (const Setting& s : run.options)
    if (s.key == "scene" && s.table.empty()) return option_text(s);
  return "";
}

std::string runs_table(const ShownRuns& runs) {
  Table table{{"run", "scene", "how it ended", "exit code", "program"}, {}, true};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunData& run = *runs[i].data;
    table.rows.push_back({name_entry(runs, i),
                          {html_text(scene_names(run))},
                          {html_text(end_words(run))},
                          {run.summary ? shown(run.summary->exit_code, whole_text) : kNone},
                          {html_text(version_of(run))}});
  }
  return html_table(table);
}

std::string options_table(const ShownRuns& runs) {
  std::vector<const RunData*> data;
  for (const ShownRun& r : runs) data.push_back(r.data);
  Table table{{"option"}, {}, true};
  for (std::size_t i = 0; i < runs.size(); ++i) table.head.push_back(name_entry(runs, i).html);
  for (const OptionRow& option : telling_options(data)) {
    Row row{{html_text(option.key)}};
    for (const std::string& value : option.values)
      row.push_back({value.empty() ? "<span class=\"soft\">not set</span>" : html_text(value),
                     option.differs});
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return html_paragraph("All options are at their defaults.", "soft");
  return html_table(table) +
         html_paragraph(runs.size() > 1
                            ? "Options that differ between the runs are marked; all that are "
                              "not named are at their defaults in all of them."
                            : "All options that are not named are at their defaults.",
                        "soft");
}

std::string figures_section(const ShownRuns& runs) {
  Table table{
      {"run", "error asked", "estimate", "true error", "estimate ÷ true", "elements", "links",
       "rays", "iterations", "wall, s", "CPU, s", "peak, MB", "hit ratio", "elements a % of error"},
      {},
      false};
  for (std::size_t i = 0; i < runs.size(); ++i) table.rows.push_back(figures_row(runs, i));
  std::string html = html_heading("The runs in figures") + html_table(table) +
                     html_paragraph(
                         "Elements a % of error: elements ÷ the error in percent (the true "
                         "one where it is known, else the estimate); of two runs of equal "
                         "error, the one with fewer is the better. CPU: to the last line of "
                         "the history.",
                         "soft");
  const auto open = names_where(runs, [](const ShownRun& r) { return !r.data->summary; });
  if (!open.empty())
    html += html_paragraph(html_text(listed_names(open)) +
                               ": no summary yet; the figures are those of the last complete "
                               "iteration.",
                           "soft");
  return html;
}

std::string energy_section(const ShownRuns& runs) {
  Table table{{"run", "emitted, lm", "absorbed, lm", "escaped, lm", "neither, lm",
               "measured afresh: absorbed ÷ emitted − 1", "absorbed, escaped, neither"},
              {},
              false};
  std::vector<std::string> without;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const auto& s = runs[i].data->summary;
    const bool known =
        s && s->flux_emitted && *s->flux_emitted > 0 && s->flux_absorbed && s->flux_escaped;
    if (known)
      table.rows.push_back(energy_row(runs, i));
    else
      without.push_back(runs[i].name);
  }
  std::string html = html_heading("Energy balance");
  if (!table.rows.empty()) html += html_table(table);
  if (!without.empty())
    html += html_paragraph(html_text(listed_names(without)) +
                           ": no summary that tells what was emitted, absorbed and escaped.");
  return html;
}

// [THFH94, Tables 2 to 4] name these figures.
std::string memory_section(const ShownRuns& runs) {
  constexpr Column kModel[] = {
      {"clusters", &RunSummary::clusters, whole_text},
      {"patches", &RunSummary::patches, whole_text},
      {"lights", &RunSummary::lights, whole_text},
      {"cells", &RunSummary::cells, whole_text},
      {"portals", &RunSummary::portals, whole_text},
      {"links processed", &RunSummary::links_processed, whole_text},
      {"total data, MB", &RunSummary::total_data_bytes, megabytes_text},
      {"working set: links", &RunSummary::max_working_set_links, whole_text},
      {"working set: elements", &RunSummary::max_working_set_elements, whole_text},
      {"working set, MB", &RunSummary::max_working_set_bytes, megabytes_text},
      {"peak memory, MB", &RunSummary::peak_rss_bytes, megabytes_text}};
  return summary_section("Working set and memory", runs, kModel);
}

std::string transfer_section(const ShownRuns& runs) {
  constexpr Column kTransfer[] = {
      {"hit ratio", &RunSummary::hit_ratio, share_text},
      {"reads", &RunSummary::reads, whole_text},
      {"writes", &RunSummary::writes, whole_text},
      {"evictions", &RunSummary::evictions, whole_text},
      {"read, MB", &RunSummary::bytes_read, megabytes_text},
      {"written, MB", &RunSummary::bytes_written, megabytes_text},
      {"records in the store, MB", &RunSummary::store_bytes, megabytes_text},
      {"solver, s", &RunSummary::solver_seconds, seconds_text},
      {"I/O, s", &RunSummary::io_seconds, seconds_text},
      {"stalled on I/O, s", &RunSummary::stall_seconds, seconds_text},
      {"total, s", &RunSummary::total_seconds, seconds_text}};
  return summary_section("Input and output", runs, kTransfer);
}

// Runs that left out the same for the same reason share a line.
std::string left_out_section(const ShownRuns& runs) {
  Table table{{"feature", "why", "in"}, {}, true};
  std::vector<std::pair<LeftOut, std::vector<std::string>>> found;
  for (const ShownRun& r : runs) {
    if (!r.data->summary) continue;
    for (const LeftOut& l : r.data->summary->left_out) {
      auto same = std::find_if(found.begin(), found.end(), [&](const auto& f) {
        return f.first.feature == l.feature && f.first.why == l.why;
      });
      if (same == found.end()) same = found.insert(found.end(), {l, {}});
      same->second.push_back(r.name);
    }
  }
  for (const auto& [left_out, names] : found)
    table.rows.push_back(
        {{html_text(left_out.feature)},
         {html_text(left_out.why)},
         {html_text(names.size() == runs.size() && names.size() > 1 ? "all runs"
                                                                    : listed_names(names))}});
  std::string html = html_heading("What was left out, and why");
  const bool none = std::none_of(runs.begin(), runs.end(),
                                 [](const ShownRun& r) { return r.data->summary.has_value(); });
  if (none) return html + html_paragraph("No summary tells of it yet.");
  return html + (found.empty() ? html_paragraph("Nothing was left out.") : html_table(table));
}

std::string history_section(const ShownRuns& runs) {
  std::string html = html_heading("History");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunData& run = *runs[i].data;
    if (run.history.empty()) {
      html += html_paragraph(name_entry(runs, i).html + ": no history yet.");
      continue;
    }
    html += "<details><summary>" + name_entry(runs, i).html + ", " +
            whole_text(double(run.history.size())) + " lines</summary>\n" + history_table(run) +
            "</details>\n";
  }
  return html;
}

std::string table_style() {
  return R"(
.share { display: block; width: 100%; min-width: 12rem; height: 12px; overflow: visible; }
.absorbed { fill: var(--hue); } .escaped { fill: var(--hue); opacity: .4; }
.missing { fill: none; stroke: var(--hue); stroke-width: 1; stroke-dasharray: 2 2; }
.small { font-size: .92em; color: var(--soft); }
)";
}

}  // namespace atrium
