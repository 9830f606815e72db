// error_time_chart CURVES.csv: the picture of bench/error_time, a panel a scene, as SVG on stdout.
// The file's columns are scene, curve, CPU seconds, error and estimate (may be empty), rows of one
// curve in their order. A curve of a solve has its estimates dashed beside it.
#include <algorithm>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "bench/picture.h"

namespace atrium {
namespace {

struct Row {
  std::string scene, curve;
  double cpu_seconds = 0, error = 0;
  double estimate = 0;  // 0: none
};

struct SceneChart {
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
  std::vector<SceneChart> scenes;
  std::map<std::string, int> styles;
  for (const Row& r : rows) {
    if (scenes.empty() || scenes.back().scene != r.scene)
      scenes.push_back({r.scene, empty_chart(r.scene)});
    Chart& chart = scenes.back().chart;
    const int style = styles.try_emplace(r.curve, static_cast<int>(styles.size())).first->second;
    series_of(chart, r.curve, Stroke::kSolid, style).points.push_back({r.cpu_seconds, r.error});
    if (r.estimate > 0)
      series_of(chart, r.curve + ", estimated", Stroke::kDashed, style)
          .points.push_back({r.cpu_seconds, r.estimate});
  }
  std::vector<Panel> panels;
  for (const SceneChart& s : scenes) panels.push_back(chart_panel(s.scene, s.chart));
  return panels;
}

}  // namespace
}  // namespace atrium

int main(int argc, char** argv) {
  std::ifstream in(argc == 2 ? argv[1] : "");
  if (!in) {
    std::cerr << "usage: error_time_chart CURVES.csv\n";
    return 2;
  }
  const std::vector<atrium::Panel> panels = atrium::panels_of(atrium::read_rows(in));
  std::cout << atrium::picture_svg(panels, std::max<std::size_t>(1, panels.size()));
}
