#include "bench/paper_report/pictures.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "apps/picture/encode.h"
#include "apps/report/data_uri.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "bench/picture.h"

namespace atrium {
namespace {

constexpr double kMega = 1e6;

Series course(const std::string& name, const std::vector<double>& bytes, double gathers,
              Stroke stroke, int style) {
  Series s;
  s.name = s.end_name = name;
  s.style = style;
  s.stroke = stroke;
  s.marks = false;
  for (std::size_t i = 0; i < bytes.size(); ++i)
    s.points.push_back({gathers * double(i + 1) / double(bytes.size()), bytes[i] / kMega});
  return s;
}

std::string text_svg(const char* kind, double x, double y, const std::string& words) {
  std::ostringstream svg;
  svg << "<text class=\"" << kind << "\" x=\"" << x << "\" y=\"" << y << "\">" << html_text(words)
      << "</text>\n";
  return svg.str();
}

// A drawing with a chart's type and colours.
std::string drawing(double width, double height, const std::string& content) {
  std::ostringstream svg;
  svg << "<svg class=\"chart\" viewBox=\"0 0 " << width << ' ' << height << "\">\n"
      << content << "</svg>\n";
  return svg.str();
}

Result<Panel> matrix_panel(const OrderedMatrix& m, char letter) {
  constexpr double kSide = 360, kBelow = 22, kTextAt = 17;  // px
  const Result<std::string> png = encode_png(matrix_image(m.matrix));
  if (!png.ok()) return png.status();
  std::ostringstream svg;
  svg << "<image x=\"0\" y=\"0\" width=\"" << kSide << "\" height=\"" << kSide
      << "\" style=\"image-rendering: pixelated\" href=\"" << data_uri("image/png", *png)
      << "\"/>\n<rect class=\"axis\" x=\"0\" y=\"0\" width=\"" << kSide << "\" height=\"" << kSide
      << "\"/>\n"
      << text_svg("tick middle", kSide / 2, kSide + kTextAt,
                  percent_text(m.matrix.common) + " of a gather's sources are of the one before");
  const std::string title = std::string(1, letter) + ") " + m.order + " order";
  return Panel{title, kSide, kSide + kBelow, drawing(kSide, kSide + kBelow, svg.str())};
}

// px
constexpr double kRow = 22, kBetween = 14, kNames = 64, kWhose = 46, kBars = 400, kBehind = 8;
constexpr double kTextDown = 15, kTimeWidth = kNames + kWhose + kBars + 20;

// A bar of the whole time, its part of I/O dark.
std::string time_bar(double y, const char* whose, const OrderFigures& order, int hue) {
  constexpr double kHeight = 18, kInside = 52;  // px; room for the words inside
  const Figure share = io_share(order);
  if (!share) return "";
  const double left = kNames + kWhose, io = kBars * *share;
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<g class=\"hue" << hue << "\">\n"
      << "<rect class=\"band\" x=\"" << left << "\" y=\"" << y << "\" width=\"" << kBars
      << "\" height=\"" << kHeight << "\"/>\n<rect style=\"fill: var(--hue)\" x=\"" << left
      << "\" y=\"" << y << "\" width=\"" << io << "\" height=\"" << kHeight << "\"/>\n</g>\n"
      << text_svg("tick end", left - kBehind, y + kTextDown - 1, whose);
  const bool inside = io > kInside;
  svg << "<text class=\"" << (inside ? "end" : "tick") << "\""
      << (inside ? " style=\"fill: var(--paper)\"" : "") << " x=\""
      << left + io + (inside ? -kBehind : kBehind) << "\" y=\"" << y + kTextDown - 1 << "\">"
      << percent_text(*share) << "</text>\n";
  return svg.str();
}

std::string time_axis(double y) {
  constexpr double kTick = 4, kNumbers = 18, kLabel = 38;  // px, below the axis
  const double left = kNames + kWhose;
  std::ostringstream svg;
  svg << "<path class=\"axis\" d=\"M" << left << ' ' << y << 'h' << kBars;
  for (int quarter = 0; quarter <= 4; ++quarter)
    svg << 'M' << left + kBars * quarter / 4 << ' ' << y << 'v' << kTick;
  svg << "\"/>\n";
  for (int quarter = 0; quarter <= 4; ++quarter)
    svg << text_svg("tick middle", left + kBars * quarter / 4, y + kNumbers,
                    percent_text(quarter / 4.0));
  svg << text_svg("label middle", left + kBars / 2, y + kLabel,
                  "share of the iteration's time: I/O dark, solver and the rest light");
  return svg.str();
}

}  // namespace

std::string working_set_picture(const std::string& model, const HistoryEntry& iteration) {
  const double gathers = iteration.clusters_gathered.value_or(0);
  Chart chart;
  chart.title = "Working sets while solving " + model;
  chart.x = {"clusters gathered to", Scale::kLinear, TickText::kCount, {0}};
  chart.y = {"working set, MB", Scale::kLinear, TickText::kNumber, {0}};
  chart.series = {course("largest", iteration.largest_working_sets, gathers, Stroke::kSolid, 0),
                  course("mean", iteration.mean_working_sets, gathers, Stroke::kDashed, 1)};
  const std::string title = model + ": working sets in the course of iteration " +
                            whole_text(iteration.iteration.value_or(0));
  return picture_svg({chart_panel(title, chart)}, 1);
}

Result<std::string> matrices_picture(const std::vector<OrderedMatrix>& matrices) {
  constexpr std::size_t kAcross = 2;
  std::vector<Panel> panels;
  for (const OrderedMatrix& m : matrices) {
    Result<Panel> panel = matrix_panel(m, static_cast<char>('A' + panels.size()));
    if (!panel.ok()) return panel.status();
    panels.push_back(std::move(*panel));
  }
  return picture_svg(panels, kAcross);
}

std::string time_picture(std::span<const OrderFigures> ours) {
  constexpr double kAxis = 48;  // px, with its words
  std::string content;
  double y = 0;
  for (const OrderFigures& own : ours) {
    const auto paper = std::ranges::find_if(
        paper_orders(), [&](const OrderFigures& p) { return p.order == own.order; });
    const bool both = paper != paper_orders().end();
    content += text_svg("", 0, y + (both ? kRow / 2 : 0) + kTextDown, own.order);
    if (both) {
      content += time_bar(y, "paper", *paper, 1);
      y += kRow;
    }
    content += time_bar(y, "ours", own, 0);
    y += kRow + kBetween;
  }
  content += time_axis(y);
  const double height = y + kAxis;
  return picture_svg({{"Time distributions for various gather orders", kTimeWidth, height,
                       drawing(kTimeWidth, height, content)}},
                     1);
}

Figure io_share(const OrderFigures& order) {
  if (!order.io_seconds || !order.seconds || *order.seconds <= 0) return std::nullopt;
  return *order.io_seconds / *order.seconds;
}

}  // namespace atrium
