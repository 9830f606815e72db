// atrium formfactor P1 P2: form factors of two polygons, unoccluded.
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <limits>
#include <memory>

#include "apps/command.h"
#include "apps/report_json.h"
#include "solver/form_factor.h"

namespace atrium {
namespace {

constexpr double kNull = std::numeric_limits<double>::quiet_NaN();

Status named(const Status& s, const std::string& name) {
  return Status(s.code(), name, s.place(), s.cause(), s.remedy());
}

// "x y z;nx ny nz": two groups make a point and its normal.
bool is_point(const std::string& text) { return std::count(text.begin(), text.end(), ';') == 1; }

Result<PolygonFormFactors> from_point(const std::string& first, const Polygon& polygon) {
  const Result<SurfacePoint> point = parse_point(first);
  if (!point.ok()) return named(point.status(), "point");
  ATRIUM_RETURN_IF_ERROR(check_polygon(polygon, "polygon 2"));
  return PolygonFormFactors{point_to_polygon(point->x, point->normal, polygon), kNull, kNull,
                            area(polygon)};
}

Result<PolygonFormFactors> form_factors(const std::string& first, const std::string& second) {
  const Result<Polygon> p2 = parse_polygon(second);
  if (!p2.ok()) return named(p2.status(), "polygon 2");
  if (is_point(first)) return from_point(first, *p2);
  const Result<Polygon> p1 = parse_polygon(first);
  if (!p1.ok()) return named(p1.status(), "polygon 1");
  return polygon_to_polygon(*p1, *p2);
}

void print(const char* name, double value) {
  if (!std::isnan(value)) std::cout << name << ' ' << std::setprecision(17) << value << '\n';
}

}  // namespace

Command formfactor_command() {
  auto words = std::make_shared<std::vector<std::string>>();
  Command command{"formfactor", "form factors of two polygons, unoccluded", {}, {}};
  command.options.argument("POLYGONS",
                           "\"x y z;x y z;...\" twice; the first may be a point \"x y z;nx ny nz\"",
                           2, 2, *words);
  command.run = [words](const Global& global, Console&) -> Result<int> {
    const Result<PolygonFormFactors> f = form_factors((*words)[0], (*words)[1]);
    if (!f.ok()) return f.status();
    if (global.json) {
      std::cout << form_factor_json(f->f12, f->f21, f->a1, f->a2);
      return 0;
    }
    print("F12", f->f12);
    print("F21", f->f21);
    print("A1", f->a1);
    print("A2", f->a2);
    return 0;
  };
  return command;
}

}  // namespace atrium
