#include "apps/picture/svg.h"

#include <cmath>
#include <iomanip>
#include <sstream>

namespace atrium {

std::string svg_points(std::span<const Vec2> points) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1);
  for (const Vec2& p : points) text << (&p == &points.front() ? "" : " ") << p.x << ',' << p.y;
  return text.str();
}

double round_step(double x) {
  const double power = std::pow(10, std::floor(std::log10(x)));
  return x >= 5 * power ? 5 * power : x >= 2 * power ? 2 * power : power;
}

}  // namespace atrium
