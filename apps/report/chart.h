// A small chart as inline SVG: lines over two axes, linear or logarithmic, with bands, marks and
// names at their ends. Its colours and type are classes, so that it follows the page
// (apps/report/html.h) into the dark and onto paper: chart_style() goes into the page's style.
// Plain data and functions of it; no state.
#pragma once

#include <string>
#include <vector>

#include "engine/vec.h"

namespace atrium {

enum class Scale { kLinear, kLog };

// How the numbers along an axis are written. kWhole: no ticks between whole numbers.
enum class TickText { kNumber, kWhole, kCount, kPercent };

struct Axis {
  std::string label;  // with its unit
  Scale scale = Scale::kLinear;
  TickText text = TickText::kNumber;
  std::vector<double> in_view;  // beside the points'
};

enum class Stroke { kSolid, kDashed };

struct BandPoint {
  double x, low, high;
};

struct Series {
  std::string name;      // told of each mark
  std::string end_name;  // written where the line ends; empty: none
  int style = 0;         // its hue, and the shape of its marks
  Stroke stroke = Stroke::kSolid;
  bool marks = true;  // a series of one point has its mark whatever is said here
  std::vector<Vec2> points;
  std::vector<BandPoint> band;
};

// A level line across the chart.
struct Level {
  double y;
  std::string name;
};

struct Chart {
  std::string title;  // for who does not see it
  Axis x, y;
  std::vector<Series> series;
  std::vector<Level> levels;
};

// The part of an axis that is in view.
struct Span {
  Scale scale = Scale::kLinear;
  double low = 0, high = 1;

  // 0 at `low`, 1 at `high`. On a logarithmic one the value is positive.
  double place(double value) const;
};

// All of `values` with some air around; on a logarithmic one those that are positive. A single
// value lies in the middle of some air.
Span span_of(Scale scale, const std::vector<double>& values);

// Round numbers within the span, from 3 to 8 of them (whole ones only where `whole`; those can be
// fewer).
std::vector<double> ticks(const Span& span, bool whole = false);

// Is there anything in it that its axes can show?
bool has_points(const Chart& chart);

std::string chart_svg(const Chart& chart);  // has_points
std::string mark_svg(int style, Stroke stroke, const Vec2& at, const std::string& tip = "");
// A piece of a line beside the words that tell what it is; `hue`: a class ("hue2", "neutral").
// `mark`: what lies on it, around (15, 6).
std::string swatch_svg(const std::string& hue, Stroke stroke, const std::string& mark);
std::string chart_style();

}  // namespace atrium
