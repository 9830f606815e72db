#include "bench/picture.h"

#include <algorithm>
#include <sstream>

#include "apps/report/html.h"

namespace atrium {
namespace {

// px
constexpr double kChartWidth = 520, kChartHeight = 330;
constexpr double kLeft = 20, kRight = 20, kTitleAt = 32, kTop = 52, kBottom = 18;

constexpr const char* kColours = R"(
svg { --paper: #ffffff; --ink: #1d2126; --soft: #5f6871; --line: #dfe3e7;
  --hue0: #0072b2; --hue1: #d55e00; --hue2: #009e73; --hue3: #c0609a; --hue4: #b98000;
  --hue5: #3d9fd6; font-family: "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; }
.title { font-size: 16px; fill: var(--ink); }
)";

}  // namespace

Panel chart_panel(const std::string& title, const Chart& chart) {
  return {title, kChartWidth, kChartHeight, chart_svg(chart)};
}

std::string picture_svg(const std::vector<Panel>& panels, std::size_t columns) {
  double width = 0, height = 0;
  for (const Panel& p : panels) {
    width = std::max(width, kLeft + p.width + kRight);
    height = std::max(height, kTop + p.height + kBottom);
  }
  const std::size_t across = std::min(columns, panels.size());
  const std::size_t rows = (panels.size() + columns - 1) / columns;
  std::ostringstream out;
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width * double(across)
      << "\" height=\"" << height * double(rows) << "\">\n<style>" << kColours << chart_style()
      << "</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const double left = kLeft + width * double(i % columns), top = height * double(i / columns);
    out << "<text class=\"title\" x=\"" << left << "\" y=\"" << top + kTitleAt << "\">"
        << html_text(panels[i].title) << "</text>\n<svg x=\"" << left << "\" y=\"" << top + kTop
        << "\" width=\"" << panels[i].width << "\" height=\"" << panels[i].height << "\">\n"
        << panels[i].drawing << "</svg>\n";
  }
  out << "</svg>\n";
  return out.str();
}

}  // namespace atrium
