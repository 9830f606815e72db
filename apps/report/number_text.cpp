#include "apps/report/number_text.h"

#include <cmath>
#include <cstdio>

namespace atrium {
namespace {

constexpr const char* kMinus = "−";
constexpr double kGrouped = 1000;    // from here on no digits behind the point
constexpr double kDecimals = 1e-4;   // below, a power of ten
constexpr double kMostWhole = 1e15;  // above, likewise
constexpr double kRounding = 1e-12;  // of a logarithm: 1e-6 is no 9.99e-7

// Of columns: what is smaller has more digits than the others.
constexpr double kFineShare = 1e-4, kFineSeconds = 0.01, kFineMegabytes = 0.1;
constexpr double kMega = 1e6;

std::string printed(const char* format, double x) {
  char text[64];
  std::snprintf(text, sizeof text, format, x);
  return text;
}

// A minus of ASCII in front becomes a true one.
std::string with_minus(const std::string& text) {
  return text.starts_with('-') ? std::string(kMinus).append(text, 1) : text;
}

std::string superscript(int n) {
  constexpr const char* kDigits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = n < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(n))) text += kDigits[c - '0'];
  return text;
}

std::string power_text(double x) {
  const int exponent = static_cast<int>(std::floor(std::log10(std::abs(x)) + kRounding));
  const double mantissa = x / std::pow(10, exponent);
  std::string text = with_minus(printed("%.3g", mantissa));
  text = text == "1" ? "" : text.append("·");
  return text.append("10").append(superscript(exponent));
}

}  // namespace

std::string whole_text(double x) {
  if (std::abs(x) >= kMostWhole) return power_text(x);
  std::string digits = printed("%.0f", x);
  const std::size_t first = digits.starts_with('-') ? 1 : 0;
  for (std::size_t at = digits.size(); at > first + 3;) digits.insert(at -= 3, 1, ',');
  return with_minus(digits);
}

std::string number_text(double x) {
  const double size = std::abs(x);
  if (size >= kGrouped) return whole_text(x);
  if (size > 0 && size < kDecimals) return power_text(x);
  return with_minus(printed("%.4g", x));
}

std::string count_text(double x) {
  constexpr struct {
    double size;
    const char* name;
  } kUnits[] = {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}};
  for (const auto& unit : kUnits)
    if (std::abs(x) >= unit.size) return number_text(x / unit.size) + unit.name;
  return number_text(x);
}

std::string percent_text(double x) { return with_minus(printed("%.3g", 100 * x)) + "%"; }

std::string share_text(double x) {
  if (x != 0 && std::abs(x) < kFineShare) return percent_text(x);
  return with_minus(printed("%.2f", 100 * x)) + "%";
}

std::string signed_share_text(double x) {
  return std::string(x > 0 ? "+" : "").append(share_text(x));
}

std::string seconds_text(double x) {
  if (x >= kGrouped || (x > 0 && x < kFineSeconds)) return number_text(x);
  return printed("%.2f", x);
}

std::string megabytes_text(double x) {
  const double megabytes = x / kMega;
  if (megabytes >= kGrouped || (x > 0 && megabytes < kFineMegabytes)) return number_text(megabytes);
  return printed("%.1f", megabytes);
}

}  // namespace atrium
