// Pages of HTML that are XML too (every tag closed), self-contained: their style is in them, and
// nothing is fetched. Light or dark as the reader's system is, and light on paper.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace atrium {

// Hues that a colour-blind reader tells apart, after Okabe and Ito: var(--hue0) and so on in CSS.
inline constexpr int kHues = 6;

// Anything as text of a page or between the quotes of an attribute. What is no UTF-8, or a control
// character, becomes U+FFFD.
std::string html_text(std::string_view text);

// body: HTML. style: beside what every page has.
std::string html_page(const std::string& title, const std::string& style, const std::string& body);

std::string html_heading(std::string_view words);  // of a section
// kind: of the page's style; "" for none. A paragraph's is HTML already.
std::string html_paragraph(const std::string& html, const std::string& kind = "");

struct TableEntry {
  std::string html;
  bool marked = false;  // stands out
};

// Its first column are names, the others numbers, or words.
struct Table {
  std::vector<std::string> head;  // HTML
  std::vector<std::vector<TableEntry>> rows;
  bool of_words = false;
};

std::string html_table(const Table& table);

}  // namespace atrium
