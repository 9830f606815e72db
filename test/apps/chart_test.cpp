#include "apps/report/chart.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <regex>

#include "apps/picture/svg.h"
#include "apps/report/html.h"
#include "apps/report/number_text.h"
#include "test/apps/well_formed.h"

namespace atrium::testing {
namespace {

constexpr double kExact = 1e-12;
constexpr double kDrawn = 0.1;  // px: places are written with one digit behind the point

void expect_near(const std::vector<double>& found, const std::vector<double>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_NEAR(found[i], expected[i], kExact * std::abs(expected[i]));
}

TEST(RoundStep, IsOneTwoOrFiveTimesAPowerOfTen) {
  EXPECT_DOUBLE_EQ(round_step(1), 1);
  EXPECT_DOUBLE_EQ(round_step(1.99), 1);
  EXPECT_DOUBLE_EQ(round_step(2), 2);
  EXPECT_DOUBLE_EQ(round_step(4.9), 2);
  EXPECT_DOUBLE_EQ(round_step(9.9), 5);
  EXPECT_DOUBLE_EQ(round_step(0.07), 0.05);
  EXPECT_DOUBLE_EQ(round_step(12345), 10000);
}

TEST(Span, ALogarithmicOnePlacesEqualRatiosAtEqualDistances) {
  const Span span{Scale::kLog, 1, 1000};
  EXPECT_NEAR(span.place(1), 0, kExact);
  EXPECT_NEAR(span.place(10), 1.0 / 3, kExact);
  EXPECT_NEAR(span.place(100), 2.0 / 3, kExact);
  EXPECT_NEAR(span.place(1000), 1, kExact);
}

TEST(Span, ALinearOnePlacesEqualDifferencesAtEqualDistances) {
  const Span span{Scale::kLinear, -2, 6};
  EXPECT_NEAR(span.place(0), 0.25, kExact);
  EXPECT_NEAR(span.place(4), 0.75, kExact);
}

// The same air at both ends: 4% of two decades, 4% of 10.
TEST(Span, ValuesHaveAirAround) {
  const Span log = span_of(Scale::kLog, {100, 1, 10});
  EXPECT_NEAR(std::log10(log.low), -0.08, kExact);
  EXPECT_NEAR(std::log10(log.high), 2.08, kExact);
  const Span linear = span_of(Scale::kLinear, {10, 0});
  EXPECT_NEAR(linear.low, -0.4, kExact);
  EXPECT_NEAR(linear.high, 10.4, kExact);
}

TEST(Span, NoiseIsNotBlownUpToFillALogarithmicOne) {
  const Span span = span_of(Scale::kLog, {0.0200, 0.0201});
  EXPECT_GE(span.high / span.low, 2);
  EXPECT_NEAR(std::sqrt(span.low * span.high), std::sqrt(0.02 * 0.0201), kExact);
}

TEST(Span, WhatALogarithmicOneCannotShowDoesNotCount) {
  const double nan = std::nan("");
  const Span with = span_of(Scale::kLog, {0, 1, -3, 100, nan});
  const Span without = span_of(Scale::kLog, {1, 100});
  EXPECT_EQ(with.low, without.low);
  EXPECT_EQ(with.high, without.high);
}

TEST(Span, ASingleValueLiesInTheMiddle) {
  for (const double value : {0.0, 1.0, -5.0})
    EXPECT_NEAR(span_of(Scale::kLinear, {value}).place(value), 0.5, kExact) << value;
  EXPECT_NEAR(span_of(Scale::kLog, {7}).place(7), 0.5, kExact);
}

TEST(Ticks, AreRoundNumbers) {
  expect_near(ticks({Scale::kLinear, 0, 1}), {0, 0.2, 0.4, 0.6, 0.8, 1});
  expect_near(ticks({Scale::kLinear, -30, 120}), {0, 50, 100});
  expect_near(ticks({Scale::kLog, 1, 100}), {1, 2, 5, 10, 20, 50, 100});
  expect_near(ticks({Scale::kLog, 0.35, 0.85}), {0.4, 0.5, 0.6, 0.7, 0.8});
  expect_near(ticks({Scale::kLog, 1e-6, 1}), {1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1});
}

// 13 powers of ten are too many: every second one.
// The air below zero makes it the first round number from below: a zero with a sign.
TEST(Ticks, ZeroHasNoSign) {
  const std::vector<double> found = ticks(span_of(Scale::kLinear, {0, 10}));
  ASSERT_EQ(found.front(), 0);
  EXPECT_FALSE(std::signbit(found.front()));
}

TEST(Ticks, ManyDecadesHaveEverySecondOrThird) {
  expect_near(ticks({Scale::kLog, 1e-6, 1e6}), {1e-6, 1e-4, 1e-2, 1, 1e2, 1e4, 1e6});
}

TEST(Ticks, OfIterationsAreWhole) {
  expect_near(ticks({Scale::kLinear, 0.9, 3.1}, true), {1, 2, 3});
  expect_near(ticks({Scale::kLinear, 0.9, 1.1}, true), {1});
}

TEST(Ticks, OfAnySpanAreFewInsideAndApart) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> decades(0.31, 14), place(-8, 8);
  for (int i = 0; i < 2000; ++i) {
    const double low = std::pow(10, place(random));
    for (const Scale scale : {Scale::kLog, Scale::kLinear}) {
      const Span span{scale, low, low * std::pow(10, decades(random))};
      const std::vector<double> found = ticks(span);
      EXPECT_GE(found.size(), 3u) << span.low << ' ' << span.high;
      EXPECT_LE(found.size(), 8u) << span.low << ' ' << span.high;
      for (std::size_t t = 0; t < found.size(); ++t) {
        EXPECT_GE(found[t], span.low);
        EXPECT_LE(found[t], span.high);
        const double gap = t > 0 ? span.place(found[t]) - span.place(found[t - 1]) : 1;
        EXPECT_GT(gap, 0.05);
      }
    }
  }
}

Chart log_chart() {
  Chart chart;
  chart.title = "A & B";
  chart.x = {"time, s", Scale::kLog, TickText::kNumber, {}};
  chart.y = {"error", Scale::kLog, TickText::kPercent, {}};
  Series s;
  s.name = "run <1>";
  s.points = {{1, 1}, {10, 0.1}, {100, 0.01}};
  chart.series = {s};
  return chart;
}

std::vector<Vec2> places_of_marks(const std::string& svg) {
  static const std::regex kPlace("class=\"mark[^>]*translate\\(([0-9.]+) ([0-9.]+)\\)");
  std::vector<Vec2> places;
  for (std::sregex_iterator m(svg.begin(), svg.end(), kPlace), end; m != end; ++m)
    places.push_back({std::stod((*m)[1]), std::stod((*m)[2])});
  return places;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(ChartSvg, AStraightLineOfLogarithmsIsStraight) {
  const std::string svg = chart_svg(log_chart());
  EXPECT_EQ(fault_of(svg), "");
  const std::vector<Vec2> marks = places_of_marks(svg);
  ASSERT_EQ(marks.size(), 3u);
  EXPECT_NEAR(marks[1].x, (marks[0].x + marks[2].x) / 2, kDrawn);
  EXPECT_NEAR(marks[1].y, (marks[0].y + marks[2].y) / 2, kDrawn);
  EXPECT_LT(marks[0].x, marks[2].x);
  EXPECT_LT(marks[0].y, marks[2].y) << "less is lower, and y grows downwards";
}

TEST(ChartSvg, TellsUnitsAndValuesAndEscapesNames) {
  const std::string svg = chart_svg(log_chart());
  EXPECT_TRUE(has(svg, ">time, s</text>"));
  EXPECT_TRUE(has(svg, ">1%</text>"));
  EXPECT_TRUE(has(svg, "<title>run &lt;1&gt;: time, s 10, 10%</title>"));
  EXPECT_TRUE(has(svg, "aria-label=\"A &amp; B\""));
}

TEST(ChartSvg, TheBandEndsWhereTheAxisDoes) {
  Chart chart = log_chart();
  chart.series[0].band = {{1, 0.5, 1.5}, {10, -0.1, 0.3}};
  const std::string svg = chart_svg(chart);
  EXPECT_FALSE(has(svg, "nan"));
  EXPECT_FALSE(has(svg, "inf"));
  static const std::regex kBand("class=\"band hue0\" points=\"([^\"]*)\"");
  std::smatch band;
  ASSERT_TRUE(std::regex_search(svg, band, kBand));
  // The axis is where y = 0.01 has its air below it; the band's third point stands on it.
  const std::string points = band[1];
  static const std::regex kBase("class=\"axis\" d=\"M[0-9.]+ ([0-9.]+)");
  std::smatch base;
  ASSERT_TRUE(std::regex_search(svg, base, kBase));
  EXPECT_TRUE(has(points, "," + base[1].str())) << points;
}

TEST(ChartSvg, NamesAtTheEndsDoNotRunIntoEachOther) {
  Chart chart = log_chart();
  for (int run = 0; run < 5; ++run) {
    Series s = chart.series[0];
    s.end_name = "run" + std::to_string(run);
    s.style = run;
    chart.series.push_back(s);
  }
  const std::string svg = chart_svg(chart);
  static const std::regex kName("class=\"name hue[0-9]\" x=\"[0-9.]+\" y=\"([0-9.]+)\"");
  std::vector<double> heights;
  for (std::sregex_iterator m(svg.begin(), svg.end(), kName), end; m != end; ++m)
    heights.push_back(std::stod((*m)[1]));
  ASSERT_EQ(heights.size(), 5u);
  std::sort(heights.begin(), heights.end());
  for (std::size_t i = 1; i < heights.size(); ++i) EXPECT_GE(heights[i] - heights[i - 1], 13.9);
}

TEST(ChartSvg, APointAloneIsMarkedThoughItsLineHasNoMarks) {
  Chart chart = log_chart();
  chart.series[0].marks = false;
  EXPECT_TRUE(places_of_marks(chart_svg(chart)).empty());
  chart.series[0].points.resize(1);
  EXPECT_EQ(places_of_marks(chart_svg(chart)).size(), 1u);
}

TEST(ChartSvg, NothingPositiveIsNothingToDrawOnLogarithms) {
  Chart chart = log_chart();
  EXPECT_TRUE(has_points(chart));
  for (Vec2& p : chart.series[0].points) p.y = 0;
  EXPECT_FALSE(has_points(chart));
  chart.series.clear();
  EXPECT_FALSE(has_points(chart));
}

TEST(ChartSvg, LongNamesKeepTheirEndsAndWholeCharacters) {
  Chart chart = log_chart();
  chart.series[0].end_name = "ääääääääääääääääääää";
  const std::string svg = chart_svg(chart);
  EXPECT_FALSE(has(svg, "\xEF\xBF\xBD"));
  EXPECT_TRUE(has(svg, "ä…ä"));
}

TEST(NumberText, GroupsRoundsAndHasNoExponents) {
  EXPECT_EQ(whole_text(1234567), "1,234,567");
  EXPECT_EQ(whole_text(-1234), "−1,234");
  EXPECT_EQ(whole_text(999), "999");
  EXPECT_EQ(number_text(0.34312), "0.3431");
  EXPECT_EQ(number_text(12345.6), "12,346");
  EXPECT_EQ(number_text(2e-6), "2·10⁻⁶");
  EXPECT_EQ(number_text(1e-6), "10⁻⁶");
  EXPECT_EQ(number_text(0), "0");
  EXPECT_EQ(count_text(1500), "1.5k");
  EXPECT_EQ(count_text(2e7), "20M");
  EXPECT_EQ(count_text(950), "950");
  EXPECT_EQ(percent_text(0.02134), "2.13%");
  EXPECT_EQ(share_text(0.027), "2.70%");
  EXPECT_EQ(share_text(0.00002), "0.002%");
  EXPECT_EQ(signed_share_text(0.002), "+0.20%");
  EXPECT_EQ(signed_share_text(-0.0131), "−1.31%");
  EXPECT_EQ(seconds_text(0.834), "0.83");
  EXPECT_EQ(seconds_text(1234.5), "1,234");
  EXPECT_EQ(megabytes_text(173.4e6), "173.4");
}

TEST(HtmlText, EscapesWhatHasAMeaning) {
  EXPECT_EQ(html_text("<b>&\"'"), "&lt;b&gt;&amp;&quot;&#39;");
  EXPECT_EQ(html_text("häuser €"), "häuser €");
}

TEST(HtmlText, WhatIsNoUtf8IsReplaced) {
  const std::string mark = "\xEF\xBF\xBD";
  EXPECT_EQ(html_text("a\xFFz"), "a" + mark + "z");
  EXPECT_EQ(html_text("\xC3"), mark);                           // cut short
  EXPECT_EQ(html_text("\xC0\xAF"), mark + mark);                // "/" in too many bytes
  EXPECT_EQ(html_text("\xED\xA0\x80"), mark + mark + mark);     // half a pair of UTF-16
  EXPECT_EQ(html_text(std::string("\0\x1B", 2)), mark + mark);  // control characters
}

TEST(WellFormed, PlantedFaultsAreFound) {
  EXPECT_EQ(fault_of("<p>a<br/>b <i class=\"x\">c &amp; d</i></p>"), "");
  for (const std::string page :
       {"<p>", "</p>", "<p><i></p></i>", "<p>a & b</p>", "<p class=x></p>", "<p a=\"1\" a=\"2\"/>",
        "<p a=\"<\"/>", "a > b", "<p a=\"&b\"/>", "<p", "<p>&nbsp;</p>"})
    EXPECT_NE(fault_of(page), "") << page;
}

}  // namespace
}  // namespace atrium::testing
