#include "apps/points.h"

#include <array>
#include <charconv>
#include <cmath>

namespace atrium {
namespace {

constexpr std::size_t kColumns = 6;
constexpr std::array<std::string_view, kColumns> kNames{"x", "y", "z", "nx", "ny", "nz"};
constexpr std::string_view kRemedy = "write x,y,z,nx,ny,nz: six finite numbers a line";

using Columns = std::array<std::size_t, kColumns>;

std::string_view trimmed(std::string_view s) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = s.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlanks) - first + 1);
}

// The fields of a line: between commas where there are any, else between blanks.
std::vector<std::string_view> fields_of(std::string_view line) {
  const bool commas = line.find(',') != std::string_view::npos;
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t end = commas ? line.find(',') : line.find_first_of(" \t");
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line = commas ? line.substr(end + 1) : trimmed(line.substr(end));
  }
}

bool parse_finite(std::string_view field, double& value) {
  const char* end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data(), end, value);
  return error == std::errc() && rest == end && std::isfinite(value);
}

// A first line that starts with a letter is a header.
bool is_header(std::string_view line) {
  const char c = line.front();
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

class Reader {
 public:
  explicit Reader(const std::string& file) : file_(file) {}

  Status header(std::string_view line) {
    const auto fields = fields_of(line);
    for (std::size_t c = 0; c < kColumns; ++c) {
      std::size_t at = 0;
      while (at < fields.size() && fields[at] != kNames[c]) ++at;
      if (at == fields.size()) return wrong("has no column '" + std::string(kNames[c]) + "'");
      columns_[c] = at;
    }
    return {};
  }

  Result<ProbePoint> point(std::string_view line) const {
    const auto fields = fields_of(line);
    std::array<double, kColumns> v{};
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (columns_[c] >= fields.size())
        return wrong("has no value for '" + std::string(kNames[c]) + "'");
      if (!parse_finite(fields[columns_[c]], v[c]))
        return wrong("'" + std::string(fields[columns_[c]]) + "' is not a finite number");
    }
    const ProbePoint p{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
    if (!(length(p.normal) > 0)) return wrong("has a normal of length zero");
    return p;
  }

  void next_line() { ++line_; }
  bool first() const { return first_; }
  void seen() { first_ = false; }

 private:
  Status wrong(const std::string& cause) const {
    return Status(Code::kUsage, file_, "line " + std::to_string(line_), cause,
                  std::string(kRemedy));
  }

  std::string file_;
  std::size_t line_ = 0;
  bool first_ = true;
  Columns columns_{0, 1, 2, 3, 4, 5};
};

}  // namespace

Result<std::vector<ProbePoint>> parse_points(std::string_view text, const std::string& file) {
  std::vector<ProbePoint> points;
  Reader reader(file);
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text = end == std::string_view::npos ? std::string_view() : text.substr(end + 1);
    reader.next_line();
    if (line.empty() || line.front() == '#') continue;
    const bool header = reader.first() && is_header(line);
    reader.seen();
    if (header) {
      ATRIUM_RETURN_IF_ERROR(reader.header(line));
      continue;
    }
    const Result<ProbePoint> point = reader.point(line);
    if (!point.ok()) return point.status();
    points.push_back(*point);
  }
  return points;
}

}  // namespace atrium
