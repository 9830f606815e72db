// Pictures of the benches: panels side by side, each under its title, as SVG that stands alone and
// reads on any page, light or dark.
// Plain data and functions of it; no state.
#pragma once

#include <string>
#include <vector>

#include "apps/report/chart.h"

namespace atrium {

struct Panel {
  std::string title;
  double width = 0, height = 0;  // px, of the drawing
  std::string drawing;           // SVG, from (0, 0); classes as apps/report/chart.h has them
};

Panel chart_panel(const std::string& title, const Chart& chart);  // has_points(chart)

// Row by row, so many panels in each.
std::string picture_svg(const std::vector<Panel>& panels, std::size_t columns);

}  // namespace atrium
