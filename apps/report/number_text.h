// Numbers as tables and axes show them: thousands in groups, a true minus, no e-notation.
#pragma once

#include <string>

namespace atrium {

std::string whole_text(double x);    // "12,345"
std::string number_text(double x);   // four significant digits: "0.3431", "12,345", "2·10⁻⁶"
std::string count_text(double x);    // "950", "1.5k", "20M": short, for axes
std::string percent_text(double x);  // of a share, three significant digits: 0.02134 is "2.13%"
std::string signed_percent_text(double x);  // "+0.2%", "−1.3%"

}  // namespace atrium
