#include "apps/report/chart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <numeric>
#include <sstream>

#include "apps/picture/svg.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "engine/check.h"

namespace atrium {
namespace {

// All in px of the chart's own coordinates.
constexpr double kWidth = 520, kHeight = 330;
constexpr double kLeft = 56, kTop = 30, kBottom = 44, kRight = 14;
constexpr double kMark = 3.2;       // a mark's half size
constexpr double kTextHeight = 14;  // least distance of names
constexpr double kLetter = 6.6;     // a letter's width, about
constexpr double kNameGap = 9;      // from the plot to a name behind it
constexpr std::size_t kMostLetters = 18;
constexpr std::size_t kMostMarks = 40;  // a line: more would run into each other

constexpr double kAir = 0.04;      // of a span, at each of its ends
constexpr double kLeastRatio = 2;  // of a logarithmic span's ends: less would show noise as news
constexpr double kAlone = 0.1;     // of a single value: the air on both its sides
constexpr double kLeastSteps = 3;  // between ticks
constexpr std::size_t kFewTicks = 3, kMostTicks = 8;
constexpr double kTickGap = 0.075;  // of a logarithmic span, between ticks at least

bool shown(const Span& span, double value) {
  return std::isfinite(value) && (span.scale == Scale::kLinear || value > 0);
}

std::vector<double> linear_ticks(double low, double high, bool whole) {
  double step = round_step((high - low) / kLeastSteps);
  if (whole) step = std::max(1.0, step);
  std::vector<double> found;
  // Plus nothing, for a zero from below has a sign.
  for (double n = std::ceil(low / step) + 0.0; n * step <= high; ++n) found.push_back(n * step);
  return found;
}

// Multiples of powers of ten.
std::vector<double> log_ticks(const Span& span, const std::vector<double>& multiples, int stride) {
  std::vector<double> found;
  const int first = static_cast<int>(std::floor(std::log10(span.low)));
  const int last = static_cast<int>(std::floor(std::log10(span.high)));
  for (int decade = first; decade <= last; ++decade) {
    if (decade % stride != 0) continue;
    for (const double m : multiples) {
      const double tick = m * std::pow(10, decade);
      if (tick >= span.low && tick <= span.high) found.push_back(tick);
    }
  }
  return found;
}

bool have_room(const Span& span, const std::vector<double>& ticks) {
  for (std::size_t i = 1; i < ticks.size(); ++i)
    if (span.place(ticks[i]) - span.place(ticks[i - 1]) < kTickGap) return false;
  return ticks.size() <= kMostTicks;
}

// As fine as there is room for.
std::vector<double> log_ticks(const Span& span) {
  static const std::array<std::vector<double>, 5> kMultiples{
      {{1, 2, 3, 4, 5, 6, 7, 8, 9}, {1, 2, 3, 5, 7}, {1, 2, 5}, {1, 3}, {1}}};
  for (const std::vector<double>& multiples : kMultiples) {
    std::vector<double> found = log_ticks(span, multiples, 1);
    if (!have_room(span, found)) continue;
    return found.size() >= kFewTicks ? found : linear_ticks(span.low, span.high, false);
  }
  int stride = 2;
  std::vector<double> found = log_ticks(span, {1}, stride);
  while (!have_room(span, found)) found = log_ticks(span, {1}, ++stride);
  return found;
}

std::string value_text(TickText text, double value) {
  switch (text) {
    case TickText::kPercent:
      return percent_text(value);
    case TickText::kCount:
      return count_text(value);
    case TickText::kWhole:
      return whole_text(value);
    case TickText::kNumber:
      break;
  }
  return number_text(value);
}

// The end of the character of UTF-8 that byte `at` of the text is in the middle of.
std::size_t past_character(const std::string& text, std::size_t at) {
  constexpr unsigned char kKind = 0xC0, kGoesOn = 0x80;
  while (at < text.size() && (static_cast<unsigned char>(text[at]) & kKind) == kGoesOn) ++at;
  return at;
}

// A name that is long loses its middle: what tells names apart is mostly at their ends.
std::string short_name(const std::string& name) {
  if (name.size() <= kMostLetters) return name;
  const std::size_t half = kMostLetters / 2 - 1;
  return name.substr(0, past_character(name, half)) + "…" +
         name.substr(past_character(name, name.size() - half));
}

// Moves places apart until no two are nearer than `gap`, in their order, within low and high.
void part(std::vector<double*>& places, double gap, double low, double high) {
  std::sort(places.begin(), places.end(), [](const double* a, const double* b) { return *a < *b; });
  for (std::size_t i = 0; i < places.size(); ++i)
    *places[i] = std::max(*places[i], i == 0 ? low : *places[i - 1] + gap);
  for (std::size_t i = places.size(); i-- > 0;)
    *places[i] = std::min(*places[i], i + 1 == places.size() ? high : *places[i + 1] - gap);
}

std::string classes(const Series& s) {
  return std::string(s.stroke == Stroke::kSolid ? "line hue" : "line dashed hue") +
         std::to_string(s.style % kHues);
}

class Drawing {
 public:
  explicit Drawing(const Chart& chart) : chart_(chart) {
    svg_ << std::fixed << std::setprecision(1);
    for (const Series& s : chart.series)
      letters_ = std::max(letters_, short_name(s.end_name).size());
    right_ = kWidth - kRight - (letters_ > 0 ? kNameGap + kLetter * double(letters_) : 0);
    x_ = span_of(chart.x.scale, values_along_x());
    y_ = span_of(chart.y.scale, values_along_y());
  }

  std::string draw() {
    svg_ << "<svg class=\"chart\" viewBox=\"0 0 " << kWidth << ' ' << kHeight
         << "\" role=\"img\" aria-label=\"" << html_text(chart_.title) << "\">\n";
    y_axis();
    x_axis();
    levels();
    for (const Series& s : chart_.series) band(s);
    for (const Series& s : chart_.series) line(s);
    for (const Series& s : chart_.series) marks(s);
    end_names();
    svg_ << "</svg>\n";
    return svg_.str();
  }

 private:
  std::vector<double> values_along_x() const {
    std::vector<double> values = chart_.x.in_view;
    for (const Series& s : chart_.series)
      for (const Vec2& p : visible(s)) values.push_back(p.x);
    return values;
  }

  std::vector<double> values_along_y() const {
    std::vector<double> values = chart_.y.in_view;
    for (const Series& s : chart_.series) {
      for (const Vec2& p : visible(s)) values.push_back(p.y);
      for (const BandPoint& b : s.band) values.insert(values.end(), {b.low, b.high});
    }
    for (const Level& level : chart_.levels) values.push_back(level.y);
    return values;
  }

  // What both axes can show.
  std::vector<Vec2> visible(const Series& s) const {
    std::vector<Vec2> points;
    for (const Vec2& p : s.points)
      if (shown({chart_.x.scale}, p.x) && shown({chart_.y.scale}, p.y)) points.push_back(p);
    return points;
  }

  double px(double x) const { return kLeft + x_.place(x) * (right_ - kLeft); }
  double py(double y) const { return kHeight - kBottom - y_.place(y) * (kHeight - kBottom - kTop); }
  Vec2 on_paper(const Vec2& p) const { return {px(p.x), py(p.y)}; }

  void text(const char* what, const Vec2& at, const std::string& words) {
    svg_ << "<text class=\"" << what << "\" x=\"" << at.x << "\" y=\"" << at.y << "\">"
         << html_text(words) << "</text>\n";
  }

  void y_axis() {
    constexpr double kBelow = 4, kBeside = 8, kAbove = 13;  // px: from a line to its number
    for (const double tick : ticks(y_, chart_.y.text == TickText::kWhole)) {
      svg_ << "<path class=\"grid\" d=\"M" << kLeft << ' ' << py(tick) << "H" << right_ << "\"/>\n";
      text("tick end", {kLeft - kBeside, py(tick) + kBelow}, value_text(chart_.y.text, tick));
    }
    text("label", {0, kAbove}, chart_.y.label);
  }

  void x_axis() {
    constexpr double kTick = 4, kNumbers = 18, kLabel = 36;  // px, below the axis
    const double base = kHeight - kBottom;
    svg_ << "<path class=\"axis\" d=\"M" << kLeft << ' ' << base << "H" << right_;
    const std::vector<double> found = ticks(x_, chart_.x.text == TickText::kWhole);
    for (const double tick : found) svg_ << 'M' << px(tick) << ' ' << base << 'v' << kTick;
    svg_ << "\"/>\n";
    for (const double tick : found)
      text("tick middle", {px(tick), base + kNumbers}, value_text(chart_.x.text, tick));
    text("label middle", {(kLeft + right_) / 2, base + kLabel}, chart_.x.label);
  }

  void levels() {
    constexpr double kIn = 4, kAbove = 5;  // px
    std::vector<double> heights;
    for (const Level& level : chart_.levels) {
      svg_ << "<path class=\"level\" d=\"M" << kLeft << ' ' << py(level.y) << "H" << right_
           << "\"/>\n";
      heights.push_back(py(level.y) - kAbove);
    }
    std::vector<double*> places;
    for (double& h : heights) places.push_back(&h);
    part(places, kTextHeight, kTop, kHeight - kBottom - kAbove);
    for (std::size_t i = 0; i < heights.size(); ++i)
      text("tick end halo", {right_ - kIn, heights[i]}, chart_.levels[i].name);
  }

  void band(const Series& s) {
    std::vector<Vec2> outline;
    const double floor = y_.low;
    for (const BandPoint& b : s.band)
      if (shown(x_, b.x)) outline.push_back(on_paper({b.x, std::max(b.high, floor)}));
    for (auto b = s.band.rbegin(); b != s.band.rend(); ++b)
      if (shown(x_, b->x)) outline.push_back(on_paper({b->x, std::max(b->low, floor)}));
    if (outline.size() < 4) return whisker(outline, s);
    svg_ << "<polygon class=\"band hue" << s.style % kHues << "\" points=\"" << svg_points(outline)
         << "\"/>\n";
  }

  // The interval of a single point.
  void whisker(const std::vector<Vec2>& ends, const Series& s) {
    if (ends.size() == 2)
      svg_ << "<polyline class=\"line hue" << s.style % kHues << "\" points=\"" << svg_points(ends)
           << "\"/>\n";
  }

  void line(const Series& s) {
    std::vector<Vec2> points = visible(s);
    if (points.size() < 2) return;
    for (Vec2& p : points) p = on_paper(p);
    svg_ << "<polyline class=\"" << classes(s) << "\" points=\"" << svg_points(points) << "\"/>\n";
  }

  void marks(const Series& s) {
    const std::vector<Vec2> points = visible(s);
    if (!s.marks && points.size() != 1) return;
    const std::size_t stride = (points.size() + kMostMarks - 1) / kMostMarks;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if ((points.size() - 1 - i) % stride != 0) continue;
      const std::string tip = s.name + ": " + chart_.x.label + ' ' +
                              value_text(chart_.x.text, points[i].x) + ", " +
                              value_text(chart_.y.text, points[i].y);
      svg_ << mark_svg(s.style, s.stroke, on_paper(points[i]), tip);
    }
  }

  void end_names() {
    constexpr double kBelow = 4;  // px: from a text's middle to its foot
    std::vector<std::pair<const Series*, Vec2>> ends;
    for (const Series& s : chart_.series) {
      const std::vector<Vec2> points = visible(s);
      if (!s.end_name.empty() && !points.empty()) ends.push_back({&s, on_paper(points.back())});
    }
    std::vector<double> heights;
    for (const auto& [s, end] : ends) heights.push_back(end.y);
    std::vector<double*> places;
    for (double& h : heights) places.push_back(&h);
    part(places, kTextHeight, kTop, kHeight - kBottom);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const auto& [s, end] = ends[i];
      const std::string hue = "hue" + std::to_string(s->style % kHues);
      svg_ << "<path class=\"leader " << hue << "\" d=\"M" << end.x + kMark + 2 << ' ' << end.y
           << 'L' << std::max(right_, end.x + kMark + 2) << ' ' << heights[i] << "\"/>\n";
      text(("name " + hue).c_str(), {right_ + kNameGap, heights[i] + kBelow},
           short_name(s->end_name));
    }
  }

  const Chart& chart_;
  std::ostringstream svg_;
  std::size_t letters_ = 0;
  double right_ = 0;
  Span x_, y_;
};

}  // namespace

double Span::place(double value) const {
  if (scale == Scale::kLinear) return (value - low) / (high - low);
  return std::log(value / low) / std::log(high / low);
}

Span span_of(Scale scale, const std::vector<double>& values) {
  std::vector<double> known;
  for (const double v : values)
    if (shown({scale}, v)) known.push_back(v);
  ATRIUM_CHECK(!known.empty());
  const auto [least, most] = std::minmax_element(known.begin(), known.end());
  double low = *least, high = *most;
  if (scale == Scale::kLog) {
    const double widened = std::sqrt(std::max(1.0, kLeastRatio * low / high));
    const double air = widened * std::pow(high / low * widened * widened, kAir);
    return {scale, low / air, high * air};
  }
  if (low == high) {
    const double around = low == 0 ? 1 : kAlone * std::abs(low);
    return {scale, low - around, high + around};
  }
  const double air = kAir * (high - low);
  return {scale, low - air, high + air};
}

std::vector<double> ticks(const Span& span, bool whole) {
  if (span.scale == Scale::kLinear) return linear_ticks(span.low, span.high, whole);
  return log_ticks(span);
}

bool has_points(const Chart& chart) {
  for (const Series& s : chart.series)
    for (const Vec2& p : s.points)
      if (shown({chart.x.scale}, p.x) && shown({chart.y.scale}, p.y)) return true;
  return false;
}

std::string chart_svg(const Chart& chart) { return Drawing(chart).draw(); }

// Filled on a solid line, hollow on a dashed one.
std::string mark_svg(int style, Stroke stroke, const Vec2& at, const std::string& tip) {
  constexpr const char* kShapes[] = {
      "M-3.2 0a3.2 3.2 0 1 0 6.4 0a3.2 3.2 0 1 0 -6.4 0z", "M-2.9 -2.9h5.8v5.8h-5.8z",
      "M0 -3.8l3.6 6.4h-7.2z", "M0 -4.1l4.1 4.1l-4.1 4.1l-4.1 -4.1z", "M0 3.8l3.6 -6.4h-7.2z"};
  std::ostringstream svg;
  svg << std::fixed << std::setprecision(1) << "<path class=\"mark"
      << (stroke == Stroke::kSolid ? " hue" : " hollow hue") << style % kHues
      << "\" transform=\"translate(" << at.x << ' ' << at.y << ")\" d=\""
      << kShapes[static_cast<std::size_t>(style) % std::size(kShapes)] << '"';
  if (tip.empty())
    svg << "/>";
  else
    svg << "><title>" << html_text(tip) << "</title></path>\n";
  return svg.str();
}

std::string swatch_svg(const std::string& hue, Stroke stroke, const std::string& mark) {
  const char* dashed = stroke == Stroke::kDashed ? " dashed" : "";
  return "<svg class=\"swatch\" viewBox=\"0 0 30 12\"><path class=\"line " + hue + dashed +
         "\" d=\"M0 6H30\"/>" + mark + "</svg>";
}

std::string chart_style() {
  std::string style = R"(
.chart { display: block; width: 100%; height: auto; overflow: visible; }
.chart text { font-size: 12.5px; fill: var(--ink); font-variant-numeric: tabular-nums; }
.chart .tick { fill: var(--soft); }
.chart .end { text-anchor: end; }
.chart .middle { text-anchor: middle; }
.halo { stroke: var(--paper); stroke-width: 3px; paint-order: stroke; }
.swatch { height: 12px; width: 30px; vertical-align: -1px; margin-right: .35rem; overflow: visible; }
.grid { stroke: var(--line); stroke-width: 1; fill: none; }
.axis { stroke: var(--soft); stroke-width: 1; fill: none; }
.level { stroke: var(--soft); stroke-width: 1; stroke-dasharray: 1 3; stroke-linecap: round; fill: none; }
.line { stroke: var(--hue); stroke-width: 1.75; stroke-linejoin: round; fill: none; }
.dashed { stroke-dasharray: 5 3; }
.band { fill: var(--hue); opacity: .16; }
.leader { stroke: var(--hue); stroke-width: .75; opacity: .45; fill: none; }
.mark { stroke: var(--hue); stroke-width: 1.4; fill: var(--hue); }
.hollow { fill: var(--paper); }
.neutral { --hue: var(--soft); }
.chart .name { fill: var(--hue); }
)";
  for (int h = 0; h < kHues; ++h) {
    const std::string n = std::to_string(h);
    style += ".hue" + n + " { --hue: var(--hue" + n + "); }\n";
  }
  return style;
}

}  // namespace atrium
