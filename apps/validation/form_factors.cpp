// validate form-factors: closed forms where there are, adaptive quadrature where not: of the kernel
// for points, of the points' configuration factors for polygons.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "apps/validation/closed_forms.h"
#include "apps/validation/suites.h"
#include "solver/triangle_cubature.h"

namespace atrium {
namespace {

constexpr double kPi = std::numbers::pi;

// What is allowed, relative to the value: a hundred times what the solver promises of far and
// grazing polygons, and what closed forms lose by cancelling beside it.
constexpr double kRelative = 1e-8, kCancelled = 1e-13;
// What quadrature can do where faces touch, and the integrand's slope has no bound.
constexpr double kQuadrature = 1e-7;

class Judge {
 public:
  explicit Judge(const FormFactorMethods& methods) : methods_(methods) {}

  void polygons(const std::string& name, const Polygon& p, const Polygon& q, double expected,
                double allowed) {
    const Result<PolygonFormFactors> f = methods_.between(p, q);
    const double found = f.ok() ? f->f12 : std::numeric_limits<double>::quiet_NaN();
    v_.cases.push_back(within(name, expected, found, allowed));
    if (!f.ok()) v_.examples.push_back(name + ": " + f.status().message());
  }
  void polygons(const std::string& name, const Polygon& p, const Polygon& q, double expected) {
    polygons(name, p, q, expected, kRelative * expected + kCancelled);
  }
  void point(const std::string& name, const Vec3& x, const Vec3& n, const Polygon& q,
             double expected, double relative = kRelative) {
    v_.cases.push_back(
        within(name, expected, methods_.from_point(x, n, q), relative * expected + kCancelled));
  }
  double from_point(const Vec3& x, const Vec3& n, const Polygon& q) const {
    return methods_.from_point(x, n, q);
  }
  Validation take() { return std::move(v_); }

 private:
  const FormFactorMethods& methods_;
  Validation v_;
};

// ---- quadrature

constexpr int kGauss = 5, kDeepest = 24;
constexpr double kOuter = 1e-10, kInner = 1e-12;  // absolute, of one interval

template <class F>
double gauss(const F& f, double a, double b) {
  double sum = 0;
  for (int i = 0; i < kGauss; ++i)
    sum += Gauss<kGauss>::weight[i] * f(a + (b - a) * Gauss<kGauss>::node[i]);
  return (b - a) * sum;
}

// ∫ f over [a, b]: halved until two halves agree with their whole to `tolerance`.
template <class F>
double adaptive(const F& f, double a, double b, double whole, double tolerance, int depth = 0) {
  const double m = (a + b) / 2, left = gauss(f, a, m), right = gauss(f, m, b);
  if (std::abs(left + right - whole) <= tolerance || depth == kDeepest) return left + right;
  return adaptive(f, a, m, left, tolerance, depth + 1) +
         adaptive(f, m, b, right, tolerance, depth + 1);
}

// ∫ f over the unit interval.
template <class F>
double unit_integral(const F& f, double tolerance) {
  return adaptive(f, 0, 1, gauss(f, 0, 1), tolerance);
}

// The mean of f over a triangle, by Duffy's map of the unit square onto it.
template <class F>
double triangle_mean(const Vec3& a, const Vec3& b, const Vec3& c, const F& f) {
  return unit_integral(
      [&](double u) {
        return 2 * u *
               unit_integral([&](double v) { return f(a + u * (b - a) + u * v * (c - b)); },
                             kInner);
      },
      kOuter);
}

// ∫ f over a convex polygon, by the fan of its triangles.
template <class F>
double polygon_integral(const Polygon& p, const F& f) {
  double sum = 0;
  for (std::size_t i = 1; i + 1 < p.size(); ++i)
    sum +=
        0.5 * length(cross(p[i] - p[0], p[i + 1] - p[0])) * triangle_mean(p[0], p[i], p[i + 1], f);
  return sum;
}

// Nothing of a contour in it: cosθ cosθ' ÷ πr² itself.
double by_kernel(const Vec3& x, const Vec3& n, const Polygon& q) {
  const Vec3 m = normalize(area_vector(q));
  return polygon_integral(q, [&](const Vec3& y) {
    const Vec3 r = y - x;
    const double r2 = dot(r, r);
    return std::max(0.0, dot(n, r)) * std::max(0.0, -dot(m, r)) / (kPi * r2 * r2);
  });
}

double by_points(const Judge& judge, const Polygon& p, const Polygon& q) {
  const Vec3 n = normalize(area_vector(p));
  return polygon_integral(p, [&](const Vec3& x) { return judge.from_point(x, n, q); }) / area(p);
}

// ---- shapes

Polygon level(Range x, Range y, double z) {
  return {{x.lo, y.lo, z}, {x.hi, y.lo, z}, {x.hi, y.hi, z}, {x.lo, y.hi, z}};
}
Polygon flipped(Polygon p) {
  std::reverse(p.begin(), p.end());
  return p;
}
// In the plane x = 0, looking to +x.
Polygon wall(Range y, Range z) {
  return {{0, y.lo, z.lo}, {0, y.hi, z.lo}, {0, y.hi, z.hi}, {0, y.lo, z.hi}};
}
// One wide, l long, turned up by `degrees` from the floor beyond the y axis.
Polygon hinged(double l, double degrees) {
  const double c = std::cos(degrees * kPi / 180), s = std::sin(degrees * kPi / 180);
  return {{0, 0, 0}, {0, l, 0}, {c, l, s}, {c, 0, s}};
}
Polygon regular(int corners, double z) {
  Polygon p;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * kPi * k / corners;
    p.push_back({std::cos(angle), std::sin(angle), z});
  }
  return p;
}

constexpr Range kUnit{0, 1};
const Polygon kSquare = level(kUnit, kUnit, 0);

std::string number(double x) {
  std::string text = std::to_string(x);
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text + "0" : text;
}

// ---- the cases

void judge_parallel(Judge& judge) {
  for (const double d : {.0001, .01, .5, 1., 2., 10.})
    judge.polygons("unit squares " + number(d) + " apart", kSquare, flipped(level(kUnit, kUnit, d)),
                   opposite_rectangles(1, 1, d));
  constexpr double kFar = 1e4, kLong = 1e4;
  // A cosθ cosθ' ÷ πr², but for terms of (size ÷ distance)².
  const double inverse_square = 1 / (kPi * kFar * kFar);
  judge.polygons("unit squares 10000 apart", kSquare, flipped(level(kUnit, kUnit, kFar)),
                 inverse_square, inverse_square * 4 / (kFar * kFar) + kRelative * inverse_square);
  judge.polygons("strips 1 x 10000, 1 apart", level(kUnit, {0, kLong}, 0),
                 flipped(level(kUnit, {0, kLong}, 1)), opposite_rectangles(1, kLong, 1));
  constexpr Range kAside{3, 4}, kSmall{.4, .45};
  judge.polygons("unit squares 1 apart, 3 aside", kSquare, flipped(level(kAside, kUnit, 1)),
                 parallel_rectangles(kUnit, kUnit, kAside, kUnit, 1));
  judge.polygons("to a small one off the middle", kSquare, flipped(level(kSmall, kUnit, .3)),
                 parallel_rectangles(kUnit, kUnit, kSmall, kUnit, .3));
  judge.polygons("unit squares back to back", flipped(kSquare), level(kUnit, kUnit, 1), 0);
}

void judge_perpendicular(Judge& judge) {
  for (const double h : {.0001, .1, 1., 10.})
    judge.polygons("floor to wall on it, " + number(h) + " high", kSquare, wall(kUnit, {0, h}),
                   perpendicular_rectangles(h, 1, 1));
  const auto to_wall = [&](const std::string& name, Range y, Range z) {
    judge.polygons(name, kSquare, wall(y, z), floor_to_wall(kUnit, kUnit, y, z));
  };
  to_wall("floor to wall, part of the edge shared", {.25, 2}, kUnit);
  to_wall("floor to wall, a corner shared", {1, 3}, kUnit);
  to_wall("floor to wall over a gap", kUnit, {.01, .2});
  judge.polygons("floor to wall that goes through it", kSquare, wall(kUnit, {-1, 1}),
                 perpendicular_rectangles(1, 1, 1));
}

void judge_hinged(Judge& judge) {
  constexpr double kLong = 1e6;
  // Crossed strings; the ends take a share of the order of width ÷ length.
  for (const double degrees : {10., 60., 120., 170.})
    judge.polygons("long strips at " + number(degrees) + " degrees", level(kUnit, {0, kLong}, 0),
                   hinged(kLong, degrees), 1 - std::sin(degrees * kPi / 360), 3 / kLong);
  for (const double degrees : {30., 150.}) {
    const Polygon leaning = hinged(1, degrees);
    judge.polygons("squares hinged at " + number(degrees) + " degrees", kSquare, leaning,
                   by_points(judge, kSquare, leaning), kQuadrature);
  }
}

void judge_other_shapes(Judge& judge) {
  const auto by_quadrature = [&](const std::string& name, const Polygon& p, const Polygon& q) {
    judge.polygons(name, p, q, by_points(judge, p, q), kQuadrature);
  };
  by_quadrature("equilateral triangles 1 apart", regular(3, 0), flipped(regular(3, 1)));
  by_quadrature("hexagon to a square 2 apart", regular(6, 0), flipped(level({-1, 1}, {-1, 1}, 2)));
  by_quadrature("skew triangles at a common corner", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                {{0, 0, 0}, {-.2, .9, .6}, {.8, -.3, .7}});
}

// What leaves one side of a closed box arrives on the five others.
ValidationCase judge_closure(const FormFactorMethods& methods) {
  constexpr Range kDepth{0, 1}, kWidth{0, 2}, kHeight{0, 3};
  const Polygon far_wall{{1, 0, 0}, {1, 0, 3}, {1, 2, 3}, {1, 2, 0}};
  const Polygon side{{0, 0, 0}, {0, 0, 3}, {1, 0, 3}, {1, 0, 0}};
  const Polygon other_side{{0, 2, 0}, {1, 2, 0}, {1, 2, 3}, {0, 2, 3}};
  const Polygon floor = level(kDepth, kWidth, 0);
  double sum = 0;
  for (const Polygon& to :
       {wall(kWidth, kHeight), far_wall, side, other_side, flipped(level(kDepth, kWidth, 3))}) {
    const Result<PolygonFormFactors> f = methods.between(floor, to);
    sum += f.ok() ? f->f12 : std::numeric_limits<double>::quiet_NaN();
  }
  return within("from a box's floor to all others", 1, sum, kRelative);
}

void judge_points(Judge& judge) {
  const Vec3 up{0, 0, 1}, at{0, 0, 0};
  for (const double d : {.001, 1., 100.})
    judge.point("point " + number(d) + " under a corner of 2 x 1", at, up,
                flipped(level({0, 2}, kUnit, d)), element_to_parallel({0, 2}, kUnit, d));
  judge.point("point aside of a rectangle", at, up, flipped(level({2, 3}, {-1, 2}, 1)),
              element_to_parallel({2, 3}, {-1, 2}, 1));
  // Seen from the wall the floor is what a wall is seen from the floor.
  for (const double d : {.0001, .1, 2.})
    judge.point("point on a wall, " + number(d) + " over a floor 1 x 2", {0, 0, d}, {1, 0, 0},
                level(kUnit, {-1, 1}, 0), element_to_perpendicular(kUnit, {-1, 1}, d));
  const Polygon skew{{.5, -.3, .8}, {-.4, -.2, 1}, {-.1, .9, 1.3}};
  judge.point("point to a skew triangle, by its kernel", at, up, skew, by_kernel(at, up, skew));
  const Polygon hexagon = flipped(regular(6, .7));
  const Vec3 tilted = normalize(Vec3{.3, -.2, .9});
  judge.point("tilted point to a hexagon, by its kernel", at, tilted, hexagon,
              by_kernel(at, tilted, hexagon));
}

}  // namespace

Result<Validation> judge_form_factors(const FormFactorMethods& methods) {
  Judge judge(methods);
  judge_parallel(judge);
  judge_perpendicular(judge);
  judge_hinged(judge);
  judge_other_shapes(judge);
  judge_points(judge);
  Validation v = judge.take();
  v.cases.push_back(judge_closure(methods));
  return v;
}

}  // namespace atrium
