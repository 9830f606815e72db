#include "engine/quantity.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>

namespace atrium {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

constexpr double kKi = 1024, kMi = kKi * 1024, kGi = kMi * 1024, kTi = kGi * 1024;

constexpr Unit kSizes[] = {{"", 1},      {"B", 1},     {"kB", 1e3},  {"KB", 1e3},
                           {"MB", 1e6},  {"GB", 1e9},  {"TB", 1e12}, {"KiB", kKi},
                           {"MiB", kMi}, {"GiB", kGi}, {"TiB", kTi}};
constexpr Unit kLengths[] = {{"", 1},      {"m", 1},    {"um", 1e-6},   {"mm", 1e-3},
                             {"cm", 1e-2}, {"km", 1e3}, {"in", 0.0254}, {"ft", 0.3048}};
constexpr Unit kTimes[] = {{"", 1},      {"s", 1},    {"ns", 1e-9}, {"us", 1e-6},
                           {"ms", 1e-3}, {"min", 60}, {"h", 3600},  {"d", 86400}};
constexpr Unit kShares[] = {{"", 1}, {"%", 0.01}};

constexpr std::string_view kSizeRemedy = "write bytes, 64MB, 64MiB or 1.5GiB";
constexpr std::string_view kLengthRemedy = "write 25mm, 1in, 0.025m or bare metres";
constexpr std::string_view kTimeRemedy = "write 90s, 10min, 8h or bare seconds";
constexpr std::string_view kShareRemedy = "write 2% or 0.02";
constexpr std::string_view kBandwidthRemedy = "write 1GB/s or 200MiB/s";

Status refused(std::string_view kind, std::string_view text, std::string_view why,
               std::string_view remedy) {
  std::string cause = std::string(kind) + " '" + std::string(text) + "' " + std::string(why);
  return Status(Code::kUsage, "", "", std::move(cause), std::string(remedy));
}

// The number and its unit, multiplied; the same for every kind.
Result<double> parse(std::string_view kind, std::string_view text, std::span<const Unit> units,
                     std::string_view remedy) {
  double number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc::result_out_of_range)
    return refused(kind, text, "is out of range", remedy);
  if (error != std::errc()) return refused(kind, text, "does not start with a number", remedy);
  if (!std::isfinite(number)) return refused(kind, text, "is not a finite number", remedy);
  if (std::signbit(number)) return refused(kind, text, "is negative", remedy);
  const std::string_view name(rest, static_cast<std::size_t>(end - rest));
  const auto unit =
      std::find_if(units.begin(), units.end(), [&](const Unit& u) { return u.name == name; });
  if (unit == units.end())
    return refused(kind, text, "has the unknown unit '" + std::string(name) + "'", remedy);
  const double value = number * unit->factor;
  if (!std::isfinite(value)) return refused(kind, text, "is out of range", remedy);
  return value;
}

std::string number_with_unit(double value, const char* unit) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "%.4g%s", value, unit);
  return buffer;
}

}  // namespace

Result<std::uint64_t> parse_size(std::string_view text) {
  constexpr double kTooLarge = 18446744073709551616.0;  // 2^64
  // A double holds whole numbers up to 2^53 only; a bare integer is read as what it is.
  std::uint64_t whole = 0;
  const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), whole);
  if (error == std::errc() && rest == text.data() + text.size()) return whole;
  const Result<double> bytes = parse("size", text, kSizes, kSizeRemedy);
  if (!bytes.ok()) return bytes.status();
  if (*bytes >= kTooLarge) return refused("size", text, "is out of range", kSizeRemedy);
  const bool bare = text.find_first_not_of("0123456789.eE+-") == std::string_view::npos;
  if (bare && *bytes != std::floor(*bytes))
    return refused("size", text, "is not a whole number of bytes", kSizeRemedy);
  return static_cast<std::uint64_t>(std::round(*bytes));
}

Result<double> parse_length(std::string_view text) {
  return parse("length", text, kLengths, kLengthRemedy);
}

Result<double> parse_time(std::string_view text) {
  return parse("time", text, kTimes, kTimeRemedy);
}

Result<double> parse_share(std::string_view text) {
  Result<double> share = parse("share", text, kShares, kShareRemedy);
  if (share.ok() && *share > 1) return refused("share", text, "is above 100%", kShareRemedy);
  return share;
}

Result<double> parse_bandwidth(std::string_view text) {
  constexpr std::string_view kPerSecond = "/s";
  if (!text.ends_with(kPerSecond))
    return refused("bandwidth", text, "does not end in /s", kBandwidthRemedy);
  return parse("bandwidth", text.substr(0, text.size() - kPerSecond.size()), kSizes,
               kBandwidthRemedy);
}

std::string format_size(std::uint64_t bytes) {
  const double b = static_cast<double>(bytes);
  if (b >= kTi) return number_with_unit(b / kTi, " TiB");
  if (b >= kGi) return number_with_unit(b / kGi, " GiB");
  if (b >= kMi) return number_with_unit(b / kMi, " MiB");
  if (b >= kKi) return number_with_unit(b / kKi, " KiB");
  return std::to_string(bytes) + " B";
}

std::string format_length(double metres) {
  if (metres == 0 || metres >= 1) return number_with_unit(metres, " m");
  if (metres >= 1e-3) return number_with_unit(metres * 1e3, " mm");
  return number_with_unit(metres * 1e6, " um");
}

std::string format_time(double seconds) {
  char buffer[64];
  if (seconds >= 3600) {
    const auto minutes = static_cast<long long>(std::round(seconds / 60));
    std::snprintf(buffer, sizeof buffer, "%lld h %02lld min", minutes / 60, minutes % 60);
    return buffer;
  }
  if (seconds >= 60) {
    const auto whole = static_cast<long long>(std::round(seconds));
    std::snprintf(buffer, sizeof buffer, "%lld min %02lld s", whole / 60, whole % 60);
    return buffer;
  }
  if (seconds == 0 || seconds >= 1) return number_with_unit(seconds, " s");
  if (seconds >= 1e-3) return number_with_unit(seconds * 1e3, " ms");
  return number_with_unit(seconds * 1e6, " us");
}

std::string format_share(double share) { return number_with_unit(share * 100, "%"); }

}  // namespace atrium
