#include "apps/report/page.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "apps/report/chart.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "apps/report/option_table.h"
#include "apps/report/run_figures.h"

namespace atrium {
namespace {

constexpr const char* kNone = "–";  // there is no such figure

constexpr const char* kPageStyle = R"(
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr));
  gap: 1.6rem 2rem; margin: .8rem 0 0; align-items: start; }
figure { margin: 0; }
figcaption { font-size: 13px; margin-top: .2rem; }
.title { font-weight: 600; font-size: 14px; margin: 0 0 .5rem; }
.swatch { height: 12px; width: 30px; vertical-align: -1px; margin-right: .35rem; overflow: visible; }
.key { margin-right: 1.1rem; white-space: nowrap; }
.runs { margin: 1rem 0 0; }
.share { display: block; width: 100%; min-width: 12rem; height: 12px; overflow: visible; }
.absorbed { fill: var(--hue); } .escaped { fill: var(--hue); opacity: .4; }
.missing { fill: none; stroke: var(--hue); stroke-width: 1; stroke-dasharray: 2 2; }
.small { font-size: 12px; color: var(--soft); }
)";

using Row = std::vector<TableEntry>;
using Runs = std::vector<ShownRun>;

std::string paragraph(const std::string& html, const char* kind = "") {
  return *kind ? "<p class=\"" + std::string(kind) + "\">" + html + "</p>\n"
               : "<p>" + html + "</p>\n";
}

std::string heading(const std::string& words) { return "<h2>" + html_text(words) + "</h2>\n"; }

// A length of a run's line, or of one in neutral grey, with its mark.
std::string swatch(const std::string& hue, Stroke stroke, const std::string& mark) {
  const char* dashed = stroke == Stroke::kDashed ? " dashed" : "";
  return "<svg class=\"swatch\" viewBox=\"0 0 30 12\"><path class=\"line " + hue + dashed +
         "\" d=\"M0 6H30\"/>" + mark + "</svg>";
}

std::string run_swatch(std::size_t run) {
  constexpr Vec2 kMiddle{15, 6};
  const int style = static_cast<int>(run);
  return swatch("hue" + std::to_string(style % kHues), Stroke::kSolid,
                mark_svg(style, Stroke::kSolid, kMiddle));
}

TableEntry name_entry(const Runs& runs, std::size_t i) {
  return {run_swatch(i) + html_text(runs[i].name)};
}

std::string file_names(const RunData& run) {
  for (const Setting& s : run.options)
    if (s.key == "scene" && s.table.empty()) return option_text(s);
  return "";
}

std::string version_of(const RunData& run) {
  for (const Setting& s : run.options)
    if (s.key == "version" && s.table.empty()) return option_text(s);
  return run.summary ? run.summary->version : "";
}

const HistoryEntry* last_entry(const RunData& run) {
  return run.history.empty() ? nullptr : &run.history.back();
}

// Of the summary; of a run without one, as the last line of its history has it.
Figure latest(const RunData& run, Figure RunSummary::*ended, Figure HistoryEntry::*going) {
  if (run.summary) return (*run.summary).*ended;
  const HistoryEntry* last = last_entry(run);
  if (!last) return std::nullopt;
  return last->*going;
}

std::string shown(const Figure& figure, std::string (*text)(double)) {
  if (!figure) return kNone;
  return text(*figure);
}

// ---- Head

std::string end_words(const RunData& run) {
  if (run.life == RunLife::kSolving) return "still being solved when this page was made";
  if (!run.summary) return "interrupted: it did not tell of an end";
  return run.summary->stop_reason.empty() ? "ended, without a reason" : run.summary->stop_reason;
}

std::string runs_table(const Runs& runs) {
  Table table{{"run", "scene", "how it ended", "exit code", "program"}, {}, true};
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunData& run = *runs[i].data;
    table.rows.push_back({name_entry(runs, i),
                          {html_text(file_names(run))},
                          {html_text(end_words(run))},
                          {run.summary ? shown(run.summary->exit_code, whole_text) : kNone},
                          {html_text(version_of(run))}});
  }
  return html_table(table);
}

std::string options_section(const Runs& runs) {
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
  if (table.rows.empty()) return paragraph("All options are at their defaults.", "soft");
  return html_table(table) +
         paragraph(runs.size() > 1
                       ? "Options that differ between the runs are marked; all that are "
                         "not named are at their defaults in all of them."
                       : "All options that are not named are at their defaults.",
                   "soft");
}

// ---- Figures

std::string notes_html(const std::vector<std::string>& notes) {
  std::string html;
  for (const std::string& n : notes) html += (html.empty() ? "" : " ") + html_text(n);
  return html;
}

std::string figure_html(const RunFigure& figure, const std::string& caption) {
  std::string html = "<figure>\n" + paragraph(html_text(figure.chart.title), "title");
  html += has_points(figure.chart) ? chart_svg(figure.chart)
                                   : paragraph("There is nothing to draw.", "soft");
  const std::string notes = notes_html(figure.notes);
  const std::string words = caption + (caption.empty() || notes.empty() ? "" : " ") + notes;
  if (!words.empty()) html += "<figcaption>" + words + "</figcaption>\n";
  return html + "</figure>\n";
}

std::string key(Stroke stroke, const std::string& mark, const std::string& words) {
  return "<span class=\"key\">" + swatch("neutral", stroke, mark) + words + "</span> ";
}

std::string error_section(const Runs& runs) {
  std::string html = heading("Error against run time");
  const RunFigure wall = error_figure(runs, Clock::kWall);
  RunFigure cpu = error_figure(runs, Clock::kCpu);
  if (!has_points(wall.chart) && !has_points(cpu.chart))
    return html + paragraph(notes_html(wall.notes) + " There is no error to hold against time.");
  std::string keys;
  if (wall.estimates)
    keys += key(Stroke::kSolid, "<path class=\"band neutral\" d=\"M0 1H30V11H0z\"/>",
                "error estimate, in its 95% interval");
  if (wall.truths)
    keys +=
        key(Stroke::kDashed, "<circle class=\"mark hollow neutral\" cx=\"15\" cy=\"6\" r=\"3\"/>",
            "true error, at the points of the reference");
  cpu.notes.clear();  // the same as of the other
  return html + paragraph(keys) + "<div class=\"figures\">\n" + figure_html(wall, "") +
         figure_html(cpu, "") + "</div>\n";
}

std::string iteration_section(const Runs& runs) {
  std::string html = heading("Iterations");
  const auto none = names_where(runs, [](const ShownRun& r) { return r.iterations.empty(); });
  if (none.size() == runs.size())
    return html + paragraph("There is no complete iteration yet: nothing to draw.");
  for (const ShownRun& r : runs)
    if (!r.data->history.empty() && !r.iterations.empty() &&
        last_entry(*r.data)->iteration > r.iterations.back().iteration)
      html += paragraph(html_text(r.name) + ": iteration " +
                            whole_text(*last_entry(*r.data)->iteration) +
                            " is not complete and is left out here.",
                        "soft");
  return html + "<div class=\"figures\">\n" + figure_html(residual_figure(runs), "") +
         figure_html(size_figure(runs), runs.size() > 1 ? "Elements solid, links dashed." : "") +
         figure_html(hit_figure(runs), "") + figure_html(working_set_figure(runs), "") + "</div>\n";
}

// ---- Tables

// The error by which elements are judged: the true one where it is known.
Figure judged_error(const RunData& run) {
  const Figure truth = latest(run, &RunSummary::error_true, &HistoryEntry::error_true);
  return truth ? truth : latest(run, &RunSummary::error_estimate, &HistoryEntry::error_estimate);
}

std::string estimate_html(const RunData& run) {
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

Row figures_row(const Runs& runs, std::size_t i) {
  const RunData& run = *runs[i].data;
  const HistoryEntry* last = last_entry(run);
  const auto of = [&](auto ended, auto going) { return latest(run, ended, going); };
  const Figure truth = of(&RunSummary::error_true, &HistoryEntry::error_true);
  const Figure estimate = of(&RunSummary::error_estimate, &HistoryEntry::error_estimate);
  const Figure elements = of(&RunSummary::elements, &HistoryEntry::elements);
  return {name_entry(runs, i),
          {shown(error_asked(run), share_text)},
          {estimate_html(run)},
          {shown(truth, share_text)},
          {shown(ratio(estimate, truth), number_text)},
          {shown(elements, whole_text)},
          {shown(of(&RunSummary::links, &HistoryEntry::links), whole_text)},
          {shown(rays_of(run), whole_text)},
          {shown(of(&RunSummary::iterations, &HistoryEntry::iteration), whole_text)},
          {shown(of(&RunSummary::total_seconds, &HistoryEntry::seconds), seconds_text)},
          {last ? shown(last->cpu_seconds, seconds_text) : kNone},
          {shown(peak_of(run), megabytes_text)},
          {shown(of(&RunSummary::hit_ratio, &HistoryEntry::hit_ratio), share_text)},
          {shown(a_percent(elements, judged_error(run)), whole_text)}};
}

std::string figures_section(const Runs& runs) {
  Table table{{"run", "error asked", "estimate", "true error", "estimate ÷ true", "elements",
               "links", "rays", "itera&#173;tions", "wall, s", "CPU, s", "peak, MB", "hit ratio",
               "elements a % of error"},
              {},
              false};
  for (std::size_t i = 0; i < runs.size(); ++i) table.rows.push_back(figures_row(runs, i));
  std::string html = heading("The runs in figures") + html_table(table) +
                     paragraph(
                         "Elements a % of error: elements ÷ the error in percent (the true "
                         "one where it is known, else the estimate); of two runs of equal "
                         "error, the one with fewer is the better. CPU: to the last line of "
                         "the history.",
                         "soft");
  const auto open = names_where(runs, [](const ShownRun& r) { return !r.data->summary; });
  if (!open.empty())
    html += paragraph(html_text(listed_names(open)) +
                          ": no summary yet; the figures are those of the last line of the "
                          "history, and of its iteration alone.",
                      "soft");
  return html;
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

Row energy_row(const Runs& runs, std::size_t i) {
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

std::string energy_section(const Runs& runs) {
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
  std::string html = heading("Energy balance");
  if (!table.rows.empty()) html += html_table(table);
  if (!without.empty())
    html += paragraph(html_text(listed_names(without)) +
                      ": no summary that tells what was emitted, absorbed and escaped.");
  return html;
}

struct Column {
  const char* head;
  Figure RunSummary::*value;
  std::string (*text)(double);
};

std::string summary_table(const Runs& runs, std::span<const Column> columns) {
  Table table{{"run"}, {}, false};
  for (const Column& c : columns) table.head.push_back(c.head);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!runs[i].data->summary) continue;
    Row row{name_entry(runs, i)};
    for (const Column& c : columns)
      row.push_back({shown((*runs[i].data->summary).*c.value, c.text)});
    table.rows.push_back(std::move(row));
  }
  return table.rows.empty() ? "" : html_table(table);
}

// [THFH94, Tables 2 to 4] name these figures.
std::string memory_section(const Runs& runs) {
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
  std::string html = heading("Working set and memory") + summary_table(runs, kModel) +
                     heading("Input and output") + summary_table(runs, kTransfer);
  const auto open = names_where(runs, [](const ShownRun& r) { return !r.data->summary; });
  if (!open.empty())
    html += paragraph(html_text(listed_names(open)) + ": no summary, so no line in these tables.");
  return html;
}

// Runs that left out the same for the same reason share a line.
std::string left_out_section(const Runs& runs) {
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
  std::string html = heading("What was left out, and why");
  const bool none = std::none_of(runs.begin(), runs.end(),
                                 [](const ShownRun& r) { return r.data->summary.has_value(); });
  if (none) return html + paragraph("No summary tells of it yet.");
  return html + (found.empty() ? paragraph("Nothing was left out.") : html_table(table));
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

std::string history_section(const Runs& runs) {
  std::string html = heading("History");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunData& run = *runs[i].data;
    if (run.history.empty()) {
      html += paragraph(name_entry(runs, i).html + ": no history yet.");
      continue;
    }
    html += "<details><summary>" + name_entry(runs, i).html + ", " +
            whole_text(double(run.history.size())) + " lines</summary>\n" + history_table(run) +
            "</details>\n";
  }
  return html;
}

std::string title_of(const Runs& runs) {
  std::set<std::string> scenes;
  for (const ShownRun& r : runs) scenes.insert(file_names(*r.data));
  const std::string count =
      runs.size() == 1 ? runs[0].name : whole_text(double(runs.size())) + " runs";
  return scenes.size() == 1 && !scenes.begin()->empty() ? *scenes.begin() + ": " + count : count;
}

std::string given_name(const RunData& run) {
  const std::filesystem::path path = std::filesystem::path(run.directory).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace

std::vector<std::string> names_of(const std::vector<RunData>& runs) {
  std::vector<std::string> names;
  for (const RunData& run : runs) {
    const auto called_alike = [&](const RunData& other) {
      return &other != &run && given_name(other) == given_name(run);
    };
    const bool alone = std::none_of(runs.begin(), runs.end(), called_alike);
    names.push_back(alone ? given_name(run) : run.directory);
  }
  return names;
}

std::string report_page(const std::vector<RunData>& data) {
  const std::vector<std::string> names = names_of(data);
  Runs runs;
  for (std::size_t i = 0; i < data.size(); ++i)
    runs.push_back({names[i], &data[i], complete_iterations(data[i])});
  const std::string title = title_of(runs);
  const std::string body = "<h1>" + html_text(title) + "</h1>\n" + runs_table(runs) +
                           options_section(runs) + error_section(runs) + figures_section(runs) +
                           iteration_section(runs) + energy_section(runs) + memory_section(runs) +
                           left_out_section(runs) + history_section(runs);
  return html_page(title + " – Atrium", chart_style() + kPageStyle, body);
}

}  // namespace atrium
