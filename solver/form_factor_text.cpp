// The command line's polygons and points, read strictly.
#include <charconv>
#include <cmath>
#include <vector>

#include "solver/form_factor.h"

namespace atrium {

namespace {

constexpr const char* kPolygonForm = "write \"x y z;x y z;x y z\"";
constexpr const char* kPointForm = "write \"x y z;nx ny nz\"";

bool is_blank(char c) { return c == ' ' || c == '\t'; }

// Three finite numbers apart by blanks, and nothing else.
bool read_triple(std::string_view text, Vec3& out) {
  const char *at = text.data(), *end = at + text.size();
  for (int k = 0; k < 3; ++k) {
    const char* start = at;
    while (at < end && is_blank(*at)) ++at;
    if (k > 0 && at == start) return false;
    const auto [next, error] = std::from_chars(at, end, out[k]);
    if (error != std::errc() || !std::isfinite(out[k])) return false;
    at = next;
  }
  while (at < end && is_blank(*at)) ++at;
  return at == end;
}

Result<std::vector<Vec3>> read_triples(std::string_view text, const char* remedy) {
  std::vector<Vec3> out;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t to = std::min(text.find(';', from), text.size());
    Vec3 x;
    if (!read_triple(text.substr(from, to - from), x))
      return Status(Code::kUsage, std::string(text), "part " + std::to_string(out.size() + 1),
                    "not three finite numbers", remedy);
    out.push_back(x);
    from = to + 1;
  }
  return out;
}

}  // namespace

Result<Polygon> parse_polygon(std::string_view text) {
  Result<std::vector<Vec3>> corners = read_triples(text, kPolygonForm);
  if (corners.ok() && corners->size() < 3)
    return Status(Code::kUsage, std::string(text), "", "a polygon needs at least three corners",
                  kPolygonForm);
  return corners;
}

Result<SurfacePoint> parse_point(std::string_view text) {
  const Result<std::vector<Vec3>> parts = read_triples(text, kPointForm);
  if (!parts.ok()) return parts.status();
  if ((*parts).size() != 2)
    return Status(Code::kUsage, std::string(text), "", "not a point and a normal", kPointForm);
  const Vec3 n = (*parts)[1];
  const double l = length(n);
  if (!(l > 0) || !std::isfinite(l))
    return Status(Code::kUsage, std::string(text), "part 2", "the normal has no direction",
                  kPointForm);
  return SurfacePoint{(*parts)[0], n / l};
}

}  // namespace atrium
