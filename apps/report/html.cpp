#include "apps/report/html.h"

#include <cstdint>

namespace atrium {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";  // U+FFFD

constexpr const char* kStyle = R"(
:root {
  color-scheme: light dark;
  --paper: #ffffff; --ink: #1d2126; --soft: #5f6871; --line: #dfe3e7; --mark: #fdf1d3;
  --hue0: #0072b2; --hue1: #d55e00; --hue2: #009e73;
  --hue3: #c0609a; --hue4: #b98000; --hue5: #3d9fd6;
}
@media screen and (prefers-color-scheme: dark) {
  :root {
    --paper: #16191d; --ink: #e4e7ea; --soft: #98a2ac; --line: #31373e; --mark: #463a17;
    --hue0: #4ea3e0; --hue1: #f08244; --hue2: #2fbf96;
    --hue3: #df93bf; --hue4: #e6a925; --hue5: #9ad5f5;
  }
}
* { box-sizing: border-box; }
body {
  max-width: 1100px; margin: 0 auto; padding: 2rem 1.25rem 4rem;
  background: var(--paper); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", Arial, "DejaVu Sans", sans-serif;
}
h1 { font-size: 1.6rem; font-weight: 600; line-height: 1.25; margin: 0; overflow-wrap: anywhere; }
h2 { font-size: 1.08rem; font-weight: 600; margin: 2.6rem 0 .4rem; }
p { margin: .4rem 0; max-width: 46rem; }
.soft, figcaption { color: var(--soft); }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: 13px; line-height: 1.35; margin: .6rem 0;
  font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .5rem; text-align: right; vertical-align: baseline; white-space: nowrap; }
thead th { font-weight: normal; color: var(--soft); white-space: normal; vertical-align: bottom;
  border-bottom: 1px solid var(--soft); }
tbody th { font-weight: normal; }
tbody tr + tr > * { border-top: 1px solid var(--line); }
th:first-child { text-align: left; padding-left: 0; }
tbody th:first-child { white-space: normal; min-width: 8.5rem; overflow-wrap: anywhere; }
.words th, .words td { text-align: left; white-space: normal; }
.marked { background: var(--mark); }
details { margin: .8rem 0; }
summary { cursor: pointer; }
@media print {
  body { max-width: none; padding: 0; font-size: 10pt; }
  table, .small { font-size: 6.5pt; }
  th, td { padding: .15rem .3rem; }
  tbody th:first-child { min-width: 0; }
  .wide { overflow: visible; }
  figure, tr { break-inside: avoid; }
  h2 { break-after: avoid; }
}
)";

// Bytes of the character that begins here; 0 where none of UTF-8 does.
std::size_t length_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xC2 && first < 0xE0 ? 2
                             : first >= 0xE0 && first < 0xF0 ? 3
                             : first >= 0xF0 && first < 0xF5 ? 4
                                                             : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i)
    if ((byte(i) & 0xC0) != 0x80) return 0;
  if (length == 1) return 1;
  // Not the shortest form, a half of a pair of UTF-16, or beyond the last character.
  const std::uint8_t second = byte(1);
  const bool wrong = (first == 0xE0 && second < 0xA0) || (first == 0xED && second >= 0xA0) ||
                     (first == 0xF0 && second < 0x90) || (first == 0xF4 && second >= 0x90);
  return wrong ? 0 : length;
}

std::string escaped(std::string_view character) {
  switch (character[0]) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      break;
  }
  const auto first = static_cast<std::uint8_t>(character[0]);
  const bool control = first < 0x20 && first != '\t' && first != '\n';
  return control || first == 0x7F ? kReplacement : std::string(character);
}

std::string entry_html(const TableEntry& entry, const char* tag) {
  return std::string("<") + tag + (entry.marked ? " class=\"marked\">" : ">") + entry.html + "</" +
         tag + ">";
}

std::string row_html(const std::vector<TableEntry>& row) {
  std::string html = "<tr>";
  for (const TableEntry& entry : row)
    html += entry_html(entry, &entry == &row.front() ? "th" : "td");
  return html + "</tr>\n";
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string html;
  while (!text.empty()) {
    const std::size_t length = length_of(text);
    html += length == 0 ? kReplacement : escaped(text.substr(0, length));
    text.remove_prefix(length == 0 ? 1 : length);
  }
  return html;
}

std::string html_page(const std::string& title, const std::string& style, const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>" +
         html_text(title) + "</title>\n<style>" + kStyle + style + "</style>\n</head>\n<body>\n" +
         body + "</body>\n</html>\n";
}

std::string html_heading(std::string_view words) { return "<h2>" + html_text(words) + "</h2>\n"; }

std::string html_paragraph(const std::string& html, const std::string& kind) {
  return (kind.empty() ? "<p>" : "<p class=\"" + kind + "\">") + html + "</p>\n";
}

std::string html_table(const Table& table) {
  std::string html = "<div class=\"wide\"><table";
  html += table.of_words ? " class=\"words\">\n<thead><tr>" : ">\n<thead><tr>";
  for (const std::string& name : table.head) html += "<th>" + name + "</th>";
  html += "</tr></thead>\n<tbody>\n";
  for (const std::vector<TableEntry>& row : table.rows) html += row_html(row);
  return html + "</tbody>\n</table></div>\n";
}

}  // namespace atrium
