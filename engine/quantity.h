// Quantities as people write them: sizes, lengths, times, shares. One strict parser each: negative,
// NaN, infinite, overflowing, unknown units and anything trailing are refused with Code::kUsage.
// A number is decimal, with an exponent if need be (1e-6m); nothing stands between it and its unit.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine/status.h"

namespace atrium {

Result<std::uint64_t> parse_size(std::string_view text);  // bytes: 64MiB, 64MB, 1.5GiB, 4096
Result<double> parse_length(std::string_view text);       // metres: 25mm, 1in, 0.025m, 3ft, 0.5
Result<double> parse_time(std::string_view text);         // seconds: 100us, 20ms, 90s, 10min, 8h
Result<double> parse_share(std::string_view text);        // of 1: 2%, 0.02; at most 1
Result<double> parse_bandwidth(std::string_view text);    // bytes a second: 1GB/s, 200MiB/s

// For reports: three or four significant digits in the unit that fits.
std::string format_size(std::uint64_t bytes);  // "1.5 GiB"
std::string format_length(double metres);      // "25.4 mm"
std::string format_time(double seconds);       // "1 h 02 min", "12.3 s", "4.56 ms"
std::string format_share(double share);        // "2.5%"

}  // namespace atrium
