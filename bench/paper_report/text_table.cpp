#include "bench/paper_report/text_table.h"

#include <cmath>
#include <cstdio>
#include <sstream>

#include "apps/report/number_text.h"

namespace atrium {
namespace {

constexpr const char* kNone = "–";

// "12,345.6"
std::string rounded_text(double x, int decimals) {
  if (decimals == 0) return whole_text(x);
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", decimals, x);
  const std::string digits = text;
  const std::size_t point = digits.find('.');
  return whole_text(std::stod(digits.substr(0, point))) + digits.substr(point);
}

std::string read_text(const Entry& e) {
  if (!e.words.empty()) return e.words;
  return e.number ? rounded_text(*e.number / e.scale, e.decimals) + e.unit : kNone;
}

std::string csv_text(const Entry& e) {
  if (!e.number) return e.words;
  std::ostringstream text;
  text.precision(12);
  text << *e.number;
  return text.str();
}

template <class Items, class Text>
std::string joined(const Items& items, const char* between, Text text) {
  std::string line;
  for (const auto& item : items) line += (line.empty() ? "" : between) + text(item);
  return line;
}

}  // namespace

Entry word_entry(const std::string& words) { return {words, {}, 0, 1, ""}; }

Entry number_entry(std::optional<double> number, int decimals, double scale,
                   const std::string& unit) {
  return {"", number, decimals, scale, unit};
}

std::string markdown(const TextTable& table) {
  std::string text =
      "| " + joined(table.columns, " | ", [](const Column& c) { return c.title; }) + " |\n|";
  for (std::size_t i = 0; i < table.columns.size(); ++i) text += "---|";
  text += '\n';
  for (const auto& row : table.rows) text += "| " + joined(row, " | ", read_text) + " |\n";
  return text;
}

std::string csv(const TextTable& table) {
  std::string text = joined(table.columns, ",", [](const Column& c) { return c.key; }) + "\n";
  for (const auto& row : table.rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) line += (i > 0 ? "," : "") + csv_text(row[i]);
    text += line + "\n";
  }
  return text;
}

}  // namespace atrium
