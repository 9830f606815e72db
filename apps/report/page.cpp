#include "apps/report/page.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "apps/picture/encode.h"
#include "apps/report/chart.h"
#include "apps/report/data_uri.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "apps/report/run_figures.h"
#include "apps/report/run_tables.h"

namespace atrium {
namespace {

constexpr const char* kStyle = R"(
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr));
  gap: 1.6rem 2rem; margin: .8rem 0 0; align-items: start; }
figure { margin: 0; }
figcaption { font-size: 13px; margin-top: .2rem; }
.title { font-weight: 600; font-size: 14px; margin: 0 0 .5rem; }
.key { margin-right: 1.1rem; white-space: nowrap; }
.matrix { display: block; width: 100%; max-width: 26rem; border: 1px solid var(--line);
  image-rendering: pixelated; }
@media screen and (prefers-color-scheme: dark) { .matrix { filter: invert(1); } }
@media print { .figures { grid-template-columns: 1fr 1fr; gap: 1rem 1.2rem; } }
)";

std::string notes_html(const std::vector<std::string>& notes) {
  std::string html;
  for (const std::string& n : notes) html += (html.empty() ? "" : " ") + html_text(n);
  return html;
}

std::string figure_html(const RunFigure& figure, const std::string& caption) {
  std::string html = "<figure>\n" + html_paragraph(html_text(figure.chart.title), "title");
  html += has_points(figure.chart) ? chart_svg(figure.chart)
                                   : html_paragraph("There is nothing to draw.", "soft");
  const std::string notes = notes_html(figure.notes);
  const std::string words = caption + (caption.empty() || notes.empty() ? "" : " ") + notes;
  if (!words.empty()) html += "<figcaption>" + words + "</figcaption>\n";
  return html + "</figure>\n";
}

std::string key(Stroke stroke, const std::string& mark, const std::string& words) {
  return "<span class=\"key\">" + swatch_svg("neutral", stroke, mark) + words + "</span> ";
}

std::string error_section(const ShownRuns& runs) {
  std::string html = html_heading("Error against run time");
  const RunFigure wall = error_figure(runs, Clock::kWall);
  RunFigure cpu = error_figure(runs, Clock::kCpu);
  if (!has_points(wall.chart) && !has_points(cpu.chart))
    return html +
           html_paragraph(notes_html(wall.notes) + " There is no error to hold against time.");
  std::string keys;
  if (wall.estimates)
    keys += key(Stroke::kSolid, "<path class=\"band neutral\" d=\"M0 1H30V11H0z\"/>",
                "error estimate, in its 95% interval");
  if (wall.truths)
    keys +=
        key(Stroke::kDashed, "<circle class=\"mark hollow neutral\" cx=\"15\" cy=\"6\" r=\"3\"/>",
            "true error, at the points of the reference");
  cpu.notes.clear();  // the same as of the other
  return html + html_paragraph(keys) + "<div class=\"figures\">\n" + figure_html(wall, "") +
         figure_html(cpu, "") + "</div>\n";
}

std::string iteration_section(const ShownRuns& runs) {
  std::string html = html_heading("Iterations");
  const auto none = names_where(runs, [](const ShownRun& r) { return r.iterations.empty(); });
  if (none.size() == runs.size())
    return html + html_paragraph("There is no complete iteration yet: nothing to draw.");
  for (const ShownRun& r : runs) {
    if (r.iterations.empty()) continue;
    const Figure last = r.data->history.back().iteration;
    if (last > r.iterations.back().iteration)
      html += html_paragraph(html_text(r.name) + ": iteration " + whole_text(*last) +
                                 " is not complete and is left out here.",
                             "soft");
  }
  return html + "<div class=\"figures\">\n" + figure_html(residual_figure(runs), "") +
         figure_html(size_figure(runs), runs.size() > 1 ? "Elements solid, links dashed." : "") +
         figure_html(hit_figure(runs), "") + figure_html(working_set_figure(runs), "") + "</div>\n";
}

// How many clusters a cell of the picture stands for.
std::string cell_words(const InteractionMatrix& m) {
  if (m.side == m.clusters) return "";
  const std::string size = number_text(double(m.clusters) / double(m.side));
  return " A cell stands for " + size + " × " + size +
         " clusters, and is the darker the more of their pairs may see each other.";
}

std::string matrix_figure(const std::string& name, const RunInteractions& run) {
  const std::string title = html_text(name + ": " + run.order + " order");
  const Result<std::string> png = encode_png(matrix_image(*run.matrix));
  if (!png.ok()) return html_paragraph(html_text(name + ": " + png.status().cause()), "soft");
  const InteractionMatrix& m = *run.matrix;
  const double pairs = double(m.clusters) * double(m.clusters);
  return "<figure>\n" + html_paragraph(title, "title") + "<img class=\"matrix\" alt=\"" + title +
         "\" src=\"" + data_uri("image/png", *png) + "\"/>\n<figcaption>" +
         whole_text(double(m.clusters)) + " clusters, " + percent_text(double(m.pairs) / pairs) +
         " of their pairs may see each other; of what a gather may see, the one before it saw " +
         percent_text(m.common) + "." + cell_words(m) + "</figcaption>\n</figure>\n";
}

// [THFH94 figure 5]
std::string interaction_section(const ShownRuns& runs,
                                const std::vector<RunInteractions>& interactions) {
  std::string figures, without;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const RunInteractions& run = interactions[i];
    if (run.matrix)
      figures += matrix_figure(runs[i].name, run);
    else
      without += html_paragraph(
          html_text(runs[i].name + ": no interaction matrix, " + run.why_not + "."), "soft");
  }
  std::string html = html_heading("Interaction matrix");
  if (!figures.empty())
    html += html_paragraph(
                "Who may see whom: receivers upwards, sources to the right, both in the order of "
                "the gathers, the first at the lower left. Blocks along the diagonal: what a "
                "gather reads serves the next ones too.") +
            "<div class=\"figures\">\n" + figures + "</div>\n";
  return html + without;
}

std::string title_of(const ShownRuns& runs) {
  std::set<std::string> scenes;
  for (const ShownRun& r : runs) scenes.insert(scene_names(*r.data));
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

std::string report_page(const std::vector<RunData>& data,
                        const std::vector<RunInteractions>& interactions) {
  const std::vector<std::string> names = names_of(data);
  ShownRuns runs;
  for (std::size_t i = 0; i < data.size(); ++i)
    runs.push_back({names[i], &data[i], complete_iterations(data[i])});
  const std::string title = title_of(runs);
  const std::string body = "<h1>" + html_text(title) + "</h1>\n" + runs_table(runs) +
                           options_table(runs) + error_section(runs) + figures_section(runs) +
                           iteration_section(runs) + interaction_section(runs, interactions) +
                           energy_section(runs) + memory_section(runs) + transfer_section(runs) +
                           left_out_section(runs) + history_section(runs);
  return html_page(title + " – Atrium", chart_style() + table_style() + kStyle, body);
}

}  // namespace atrium
