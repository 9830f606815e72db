// error_time_chart CURVES.csv: the picture of bench/error_time, a panel a scene, as SVG on stdout.
// The file's columns are scene, curve, CPU seconds, error and estimate (may be empty), rows of one
// curve in their order. A curve of a solve has its estimates dashed beside it.
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "apps/report/chart.h"
#include "apps/report/html.h"

namespace atrium {
namespace {

// px
constexpr int kWidth = 560, kHeight = 400, kPlotWidth = 520, kPlotHeight = 330;
constexpr int kLeft = 20, kTop = 52, kTitleAt = 32;
// On any page, light or dark.
constexpr const char* kColours = R"(
svg { --paper: #ffffff; --ink: #1d2126; --soft: #5f6871; --line: #dfe3e7;
  --hue0: #0072b2; --hue1: #d55e00; --hue2: #009e73; --hue3: #c0609a; --hue4: #b98000;
  --hue5: #3d9fd6; font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; }
.title { font-size: 16px; fill: var(--ink); }
)";

struct Row {
  std::string scene, curve;
  double cpu_seconds = 0, error = 0;
  double estimate = 0;  // 0: none
};

struct Panel {
  std::string scene;
  Chart chart;
};

std::vector<Row> read_rows(std::istream& in) {
  std::vector<Row> rows;
  std::string line, seconds, error, estimate;
  std::getline(in, line);  // the header
  while (std::getline(in, line)) {
    std::istringstream cells(line);
    Row r;
    std::getline(cells, r.scene, ',');
    std::getline(cells, r.curve, ',');
    std::getline(cells, seconds, ',');
    std::getline(cells, error, ',');
    r.cpu_seconds = std::stod(seconds);
    r.error = std::stod(error);
    if (std::getline(cells, estimate, ',') && !estimate.empty()) r.estimate = std::stod(estimate);
    rows.push_back(r);
  }
  return rows;
}

Chart empty_chart(const std::string& scene) {
  Chart chart;
  chart.title = scene + ": error against CPU seconds";
  chart.x = {"CPU seconds, one thread", Scale::kLog, TickText::kNumber, {}};
  chart.y = {"error, root mean square", Scale::kLog, TickText::kPercent, {}};
  return chart;
}

Series& series_of(Chart& chart, const std::string& name, Stroke stroke, int style) {
  for (Series& s : chart.series)
    if (s.name == name) return s;
  Series s;
  s.name = name;
  s.stroke = stroke;
  s.style = style;
  if (stroke == Stroke::kSolid) s.end_name = name;
  chart.series.push_back(s);
  return chart.series.back();
}

std::vector<Panel> panels_of(const std::vector<Row>& rows) {
  std::vector<Panel> panels;
  std::map<std::string, int> styles;
  for (const Row& r : rows) {
    if (panels.empty() || panels.back().scene != r.scene)
      panels.push_back({r.scene, empty_chart(r.scene)});
    Chart& chart = panels.back().chart;
    const int style = styles.try_emplace(r.curve, static_cast<int>(styles.size())).first->second;
    series_of(chart, r.curve, Stroke::kSolid, style).points.push_back({r.cpu_seconds, r.error});
    if (r.estimate > 0)
      series_of(chart, r.curve + ", estimated", Stroke::kDashed, style)
          .points.push_back({r.cpu_seconds, r.estimate});
  }
  return panels;
}

void draw(const std::vector<Panel>& panels, std::ostream& out) {
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << kWidth * int(panels.size())
      << "\" height=\"" << kHeight << "\">\n<style>" << kColours << chart_style()
      << "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const int left = kLeft + kWidth * int(i);
    out << "<text class=\"title\" x=\"" << left << "\" y=\"" << kTitleAt << "\">"
        << html_text(panels[i].scene) << "</text>\n<svg x=\"" << left << "\" y=\"" << kTop
        << "\" width=\"" << kPlotWidth << "\" height=\"" << kPlotHeight << "\">\n"
        << chart_svg(panels[i].chart) << "</svg>\n";
  }
  out << "</svg>\n";
}

}  // namespace
}  // namespace atrium

int main(int argc, char** argv) {
  std::ifstream in(argc == 2 ? argv[1] : "");
  if (!in) {
    std::cerr << "usage: error_time_chart CURVES.csv\n";
    return 2;
  }
  atrium::draw(atrium::panels_of(atrium::read_rows(in)), std::cout);
}
