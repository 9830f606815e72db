// Numbers as tables and axes show them: thousands in groups, a true minus, no e-notation.
#pragma once

#include <string>

namespace atrium {

std::string whole_text(double x);    // "12,345"
std::string number_text(double x);   // four significant digits: "0.3431", "12,345", "2·10⁻⁶"
std::string count_text(double x);    // "950", "1.5k", "20M": short, for axes
std::string percent_text(double x);  // of a share, three significant digits: 0.02134 is "2.13%"
// For columns, which align by their last digit:
std::string share_text(double x);         // of 1: "2.13%"; smaller ones as percent_text
std::string signed_share_text(double x);  // "+0.20%", "−1.31%"
std::string seconds_text(double x);       // "0.83", "1,234"
std::string megabytes_text(double x);     // of bytes: "173.4"

}  // namespace atrium
