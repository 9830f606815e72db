// A table of words and numbers, as Markdown to be read and as CSV to be computed with.
// Plain data and functions of it; no state.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace atrium {

struct Column {
  std::string title;  // as it is read
  std::string key;    // as a CSV names it
};

// Words, or a number: `number` is what stands in the CSV; it is read in units of `scale`, rounded,
// with the unit's name behind it. Neither: there is no such figure.
struct Entry {
  std::string words;
  std::optional<double> number;
  int decimals = 0;
  double scale = 1;
  std::string unit;
};

Entry word_entry(const std::string& words);
Entry number_entry(std::optional<double> number, int decimals = 0, double scale = 1,
                   const std::string& unit = "");

struct TextTable {
  std::vector<Column> columns;
  std::vector<std::vector<Entry>> rows;
};

std::string markdown(const TextTable& table);
std::string csv(const TextTable& table);

}  // namespace atrium
