#include "solver/form_factor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "solver/triangle_cubature.h"

namespace atrium {
namespace {

constexpr double kPi = std::numbers::pi;

PolygonFormFactors between(const Polygon& p, const Polygon& q) {
  const auto f = polygon_to_polygon(p, q);
  EXPECT_TRUE(f.ok()) << f.status().message();
  return f.ok() ? *f : PolygonFormFactors{NAN, NAN, NAN, NAN};
}

void expect_relative(double found, double expected, double tolerance) {
  EXPECT_NEAR(found, expected, tolerance * std::abs(expected));
}

Polygon flipped(Polygon p) {
  std::reverse(p.begin(), p.end());
  return p;
}

Polygon moved(Polygon p, double scale, const Vec3& offset) {
  for (Vec3& x : p) x = x * scale + offset;
  return p;
}

Polygon rotated(Polygon p, const Vec3& about, double turn) {
  const Vec3 w = normalize(about);
  for (Vec3& x : p)
    x = x * std::cos(turn) + cross(w, x) * std::sin(turn) + w * dot(w, x) * (1 - std::cos(turn));
  return p;
}

// [0, a] × [0, b] at height z, looking up; flip it to look down.
Polygon level(double a, double b, double z) { return {{0, 0, z}, {a, 0, z}, {a, b, z}, {0, b, z}}; }

// Standing on the y axis, b wide and h high, looking to +x.
Polygon wall(double b, double h) { return {{0, 0, 0}, {0, b, 0}, {0, b, h}, {0, 0, h}}; }

// Opposite equal rectangles a × b at distance c. [Howell C-11]
double opposite_rectangles(double a, double b, double c) {
  const double x = a / c, y = b / c, x1 = std::sqrt(1 + x * x), y1 = std::sqrt(1 + y * y);
  return 2 / (kPi * x * y) *
         (std::log(x1 * y1 / std::sqrt(1 + x * x + y * y)) + x * y1 * std::atan(x / y1) +
          y * x1 * std::atan(y / x1) - x * std::atan(x) - y * std::atan(y));
}

// From a floor w deep to a wall h high on their common edge l. [Howell C-14]
double perpendicular_rectangles(double h, double w, double l) {
  const double p = h / l, q = w / l, p2 = p * p, q2 = q * q, s = p2 + q2;
  return 1 / (kPi * q) *
         (q * std::atan(1 / q) + p * std::atan(1 / p) - std::sqrt(s) * std::atan(1 / std::sqrt(s)) +
          0.25 * (std::log((1 + q2) * (1 + p2) / (1 + s)) +
                  q2 * std::log(q2 * (1 + s) / ((1 + q2) * s)) +
                  p2 * std::log(p2 * (1 + s) / ((1 + p2) * s))));
}

// Triangles that make up the polygon, halved `depth` times.
std::vector<Triangle> pieces_of(const Polygon& polygon, int depth) {
  std::vector<Triangle> pieces;
  EXPECT_TRUE(triangulate(polygon, pieces));
  for (; depth > 0; --depth) {
    std::vector<Triangle> halves;
    for (const Triangle& t : pieces) {
      const auto [a, b] = bisect(t);
      halves.push_back(a);
      halves.push_back(b);
    }
    pieces = halves;
  }
  return pieces;
}

// The second method: Gauss over pieces of p of the points' closed form, halved `depth` times.
double by_points(const Polygon& p, const Polygon& q, int depth) {
  const Vec3 n = plane_of(p).normal;
  double sum = 0;
  for (const Triangle& t : pieces_of(p, depth)) {
    const TriangleRule<5> rule(t);
    for (std::size_t i = 0; i < rule.at.size(); ++i)
      sum += area(t) * rule.weight[i] * point_to_polygon(rule.at[i], n, q);
  }
  return sum / area(p);
}

// The kernel itself by Gauss over pieces of the polygon: nothing of the contour in it.
double point_by_kernel(const Vec3& x, const Vec3& n, const Polygon& q, int depth) {
  const Vec3 m = plane_of(q).normal;
  double sum = 0;
  for (const Triangle& t : pieces_of(q, depth)) {
    const TriangleRule<5> rule(t);
    for (std::size_t i = 0; i < rule.at.size(); ++i) {
      const Vec3 r = rule.at[i] - x;
      const double r2 = dot(r, r);
      sum += area(t) * rule.weight[i] * std::max(0.0, dot(n, r)) * std::max(0.0, -dot(m, r)) /
             (kPi * r2 * r2);
    }
  }
  return sum;
}

struct Dice {
  std::mt19937 engine;
  double between(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(engine);
  }
  Vec3 in_cube(double a, double b) { return {between(a, b), between(a, b), between(a, b)}; }
  Vec3 direction() {
    std::normal_distribution<double> g;
    return normalize(Vec3{g(engine), g(engine), g(engine)});
  }
  // Convex, on a circle around `center`, looking along n.
  Polygon polygon(const Vec3& center, const Vec3& n, double radius, int corners) {
    const Vec3 u = normalize(cross(n, std::abs(n.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
    Polygon out;
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * kPi * (k + between(0, 0.6)) / corners;
      out.push_back(center + radius * (std::cos(angle) * u + std::sin(angle) * cross(n, u)));
    }
    return out;
  }
};

// ---- against known values

std::vector<std::string> csv_fields(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else if (c != '\r')
      fields.back() += c;
  }
  return fields;
}

TEST(FormFactor, EveryRowOfTheSharedTable) {
  std::ifstream in(ATRIUM_SHARED_DIR "/facts/form_factors.csv");
  if (!in) GTEST_SKIP() << "no " ATRIUM_SHARED_DIR "/facts/form_factors.csv";
  std::string line;
  std::getline(in, line);
  int rows = 0;
  while (std::getline(in, line)) {
    const auto field = csv_fields(line);
    ASSERT_EQ(field.size(), 8u) << line;
    SCOPED_TRACE(field[1]);
    ++rows;
    const double f12 = std::stod(field[2]);
    const auto second = parse_polygon(field[7]);
    ASSERT_TRUE(second.ok());
    if (field[0] == "point-polygon") {
      const auto point = parse_point(field[6]);
      ASSERT_TRUE(point.ok());
      expect_relative(point_to_polygon((*point).x, (*point).normal, *second), f12, 1e-9);
      continue;
    }
    const auto first = parse_polygon(field[6]);
    ASSERT_TRUE(first.ok());
    const PolygonFormFactors f = between(*first, *second);
    expect_relative(f.f12, f12, 1e-9);
    expect_relative(f.f21, std::stod(field[3]), 1e-9);
    expect_relative(f.a1, std::stod(field[4]), 1e-9);
    expect_relative(f.a2, std::stod(field[5]), 1e-9);
  }
  EXPECT_GT(rows, 20);
}

TEST(FormFactor, OppositeRectangles) {
  for (const double a : {0.01, 1.0, 30.0})
    for (const double c : {0.003, 0.3, 1.0, 3.0})
      expect_relative(between(level(a, 1, 0), flipped(level(a, 1, c))).f12,
                      opposite_rectangles(a, 1, c), 1e-9);
}

TEST(FormFactor, PerpendicularRectanglesOnACommonEdge) {
  for (const double w : {0.01, 1.0, 30.0})
    for (const double h : {0.02, 0.7, 5.0})
      expect_relative(between(level(w, 1, 0), wall(1, h)).f12, perpendicular_rectangles(h, w, 1),
                      1e-9);
}

// Two strips hinged at an angle, so long that only their section counts: 1 - sin(angle / 2) by
// crossed strings; the ends take a share of the order of width / length.
TEST(FormFactor, LongHingedStrips) {
  constexpr double kLength = 1e6;
  for (const double angle : {10.0, 60.0, 120.0, 170.0}) {
    const double a = angle * kPi / 180, c = std::cos(a), s = std::sin(a);
    const Polygon floor = level(1, kLength, 0);
    const Polygon leaning{{0, 0, 0}, {0, kLength, 0}, {c, kLength, s}, {c, 0, s}};
    EXPECT_NEAR(between(floor, leaning).f12, 1 - std::sin(a / 2), 3 / kLength);
  }
}

// Unit squares hinged almost flat: F goes with the square of what is missing to 180°, for the
// kernel goes with both sines and the squares stay where they are.
TEST(FormFactor, HingedAlmostFlat) {
  const auto hinged = [](double missing) {
    const double c = -std::cos(missing), s = std::sin(missing);
    return Polygon{{0, 0, 0}, {0, 1, 0}, {c, 1, s}, {c, 0, s}};
  };
  const double limit = between(level(1, 1, 0), hinged(0.001)).f12 / (0.001 * 0.001);
  for (const double missing : {1e-4, 1e-5}) {
    const double f = between(level(1, 1, 0), hinged(missing)).f12;
    expect_relative(f, limit * missing * missing, 1e-6);
    expect_relative(between(hinged(missing), level(1, 1, 0)).f21, f, 1e-8);
  }
}

// Squares in parallel planes one above the other's neighbourhood: F = ∫∫ of the kernel over the
// offset's distribution, a tent in x and in y. Far and grazing, where the contour cancels.
TEST(FormFactor, GrazingParallelSquares) {
  const auto by_tents = [](double offset, double h) {
    constexpr int kPieces = 64;
    double sum = 0;
    for (int i = 0; i < 2 * kPieces; ++i)
      for (int j = 0; j < 2 * kPieces; ++j)
        for (int k = 0; k < 5; ++k)
          for (int l = 0; l < 5; ++l) {
            const double u = (i + Gauss<5>::node[k]) / kPieces - 1;
            const double v = (j + Gauss<5>::node[l]) / kPieces - 1;
            const double r2 = (u + offset) * (u + offset) + v * v + h * h;
            sum += Gauss<5>::weight[k] * Gauss<5>::weight[l] * (1 - std::abs(u)) *
                   (1 - std::abs(v)) * h * h / (kPi * r2 * r2);
          }
    return sum / (kPieces * kPieces);
  };
  for (const double offset : {1.5, 3.0, 30.0})
    for (const double h : {1e-7, 1e-5, 1e-3, 0.1}) {
      const Polygon above = moved(flipped(level(1, 1, 0)), 1, {offset, 0, h});
      expect_relative(between(level(1, 1, 0), above).f12, by_tents(offset, h), 1e-8);
    }
}

// Very far: A cosθ cosθ' / π r² with a relative correction of (size / r)².
TEST(FormFactor, InverseSquareFarAway) {
  for (const double r : {1e4, 1e6, 1e8}) {
    const Polygon p = level(1, 1, 0), q = moved(flipped(level(2, 1, 0)), 1, {0, 0, r});
    expect_relative(between(p, q).f12, 2 / (kPi * r * r), 4 / (r * r) + 1e-12);
    expect_relative(between(p, q).f21, 1 / (kPi * r * r), 4 / (r * r) + 1e-12);
    expect_relative(point_to_polygon({0, 0, 0}, {0, 0, 1}, q), 2 / (kPi * r * r),
                    4 / (r * r) + 1e-9);
  }
}

TEST(FormFactor, NothingWhereNeitherSeesTheOther) {
  const Polygon floor = level(1, 1, 0);
  EXPECT_EQ(between(floor, level(1, 1, 1)).f12, 0);                    // looks away
  EXPECT_EQ(between(flipped(floor), flipped(level(1, 1, 1))).f12, 0);  // looks away below
  EXPECT_EQ(between(floor, flipped(level(1, 1, -1))).f12, 0);          // behind
  EXPECT_LT(between(floor, moved(floor, 1, {1, 0, 0})).f12, 1e-12);    // side by side
  EXPECT_LT(between(floor, floor).f12, 1e-12);
  // Side by side in a plane that rounding has bent, far from the origin.
  const Vec3 about{1, 2, 3};
  const Polygon a = moved(rotated(floor, about, 1), 1, Vec3{1e6}),
                b = moved(rotated(moved(floor, 1, {1, 0, 0}), about, 1), 1, Vec3{1e6});
  EXPECT_LT(between(a, b).f12, 1e-12);
}

// ---- two methods, one answer

TEST(FormFactor, AgreesWithGaussOverThePointsClosedForm) {
  Dice dice{std::mt19937(3)};
  for (int i = 0; i < 60; ++i) {
    const Vec3 n = dice.direction(), m = dice.direction();
    // Apart, and wholly in front of each other.
    const Polygon p = dice.polygon(dice.in_cube(-1, 1), n, 0.5, 3 + i % 5);
    const Vec3 center = dice.in_cube(-4, 4);
    const Polygon q = dice.polygon(center, m, 0.5, 3 + i % 4);
    const auto in_front = [](const Polygon& a, const Polygon& b) {
      const Plane plane = plane_of(a);
      return std::all_of(b.begin(), b.end(),
                         [&](const Vec3& x) { return plane.distance(x) > 0.2; });
    };
    if (!in_front(p, q) || !in_front(q, p)) continue;
    const PolygonFormFactors f = between(p, q);
    expect_relative(f.f12, by_points(p, q, 6), 1e-8);
    expect_relative(f.f21, by_points(q, p, 6), 1e-8);
  }
}

// Anyhow, through each other's planes too: there the points' values have kinks.
TEST(FormFactor, AgreesWithGaussWhereTheyAreClipped) {
  Dice dice{std::mt19937(5)};
  int seen = 0;
  for (int i = 0; i < 100; ++i) {
    const Polygon p = dice.polygon({0, 0, 0}, dice.direction(), 0.6, 3 + i % 5);
    const Polygon q = dice.polygon(2.0 * dice.direction(), dice.direction(), 0.6, 3 + i % 4);
    const PolygonFormFactors f = between(p, q);
    EXPECT_NEAR(f.f12, by_points(p, q, 8), 2e-6);
    EXPECT_GE(f.f12, 0);
    seen += f.f12 > 1e-3;
  }
  EXPECT_GT(seen, 20);  // many are turned away
}

TEST(PointFormFactor, AgreesWithTheKernel) {
  Dice dice{std::mt19937(7)};
  for (int i = 0; i < 300; ++i) {
    const Vec3 n = dice.direction();
    const int corners = 3 + i % 9;
    const Polygon q = dice.polygon(4.0 * dice.direction(), dice.direction(), 1, corners);
    const bool cut = std::any_of(q.begin(), q.end(), [&](auto& x) { return dot(n, x) < 0; }) &&
                     std::any_of(q.begin(), q.end(), [&](auto& x) { return dot(n, x) > 0; });
    EXPECT_NEAR(point_to_polygon({0, 0, 0}, n, q), point_by_kernel({0, 0, 0}, n, q, 7),
                cut ? 1e-5 : 1e-11);
  }
}

TEST(PointFormFactor, SmallAndGrazingKeepTheirDigits) {
  Dice dice{std::mt19937(9)};
  for (int i = 0; i < 300; ++i) {
    const double size = std::pow(10, dice.between(-9, -1.5));
    const double lift = std::pow(10, dice.between(-6, -0.5));
    // Seen flat by the point and seeing it flat.
    const Vec3 center{1, dice.between(-1, 1), lift};
    const Vec3 m = normalize(cross(cross(center, Vec3{dice.between(-1, 1), 1, 1}), center) -
                             dice.between(0, 1) * lift * center);
    const Polygon q = dice.polygon(center, m, std::min(size, 0.3 * lift), 3 + i % 4);
    const double expected = point_by_kernel({0, 0, 0}, {0, 0, 1}, q, 4);
    if (dot(m, center) > -1e-9) continue;
    expect_relative(point_to_polygon({0, 0, 0}, {0, 0, 1}, q), expected, 2e-7);
  }
}

// ---- laws

TEST(FormFactor, Reciprocity) {
  Dice dice{std::mt19937(11)};
  for (int i = 0; i < 200; ++i) {
    const Polygon p = dice.polygon({0, 0, 0}, dice.direction(), 1, 3 + i % 5);
    const Polygon q = dice.polygon(1.5 * dice.direction(), dice.direction(), 0.3, 3 + i % 4);
    const PolygonFormFactors f = between(p, q), g = between(q, p);
    EXPECT_NEAR(f.a1 * f.f12, f.a2 * f.f21, 1e-15);
    EXPECT_NEAR(f.f12, g.f21, 1e-10);  // found with the roles of the integrals exchanged
    EXPECT_NEAR(f.f21, g.f12, 1e-10);
  }
}

TEST(FormFactor, PartsAddUp) {
  const Polygon floor = level(2, 1, 0);
  const Polygon near{{0, 0, 0}, {0, 1, 0}, {0, 1, 0.3}, {0, 0, 0.3}};
  const Polygon far{{0, 0, 0.3}, {0, 1, 0.3}, {0, 1, 2}, {0, 0, 2}};
  expect_relative(between(floor, near).f12 + between(floor, far).f12,
                  between(floor, wall(1, 2)).f12, 1e-12);
}

// An L of three squares is the sum of the square and the two-square it is cut into, from polygons
// and points, above the horizon or through it.
TEST(FormFactor, ConcavePolygonIsTheSumOfItsParts) {
  const Polygon l{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  const Polygon bar = level(2, 1, 0), square{{0, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}};
  Dice dice{std::mt19937(13)};
  for (int i = 0; i < 100; ++i) {
    const Vec3 at = dice.in_cube(-1, 2.5) + Vec3{0, 0, 0.6}, n = dice.direction();
    EXPECT_NEAR(point_to_polygon(at, n, l),
                point_to_polygon(at, n, bar) + point_to_polygon(at, n, square), 1e-13);
    const Polygon q = dice.polygon(at, n, 0.5, 3 + i % 4);
    const double whole = between(q, l).f12, parts = between(q, bar).f12 + between(q, square).f12;
    EXPECT_NEAR(whole, parts, 1e-10);
  }
  // Only the tips of a U stand out of the other's floor: what is between them gives nothing.
  const Polygon u{{0, 0, -1},   {0, 3, -1},   {0, 3, 1}, {0, 2, 1},
                  {0, 2, -0.5}, {0, 1, -0.5}, {0, 1, 1}, {0, 0, 1}};
  const Polygon floor = moved(level(3, 3, 0), 1, {0.1, 0, 0});
  const Polygon left{{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}, right = moved(left, 1, {0, 2, 0});
  expect_relative(between(floor, u).f12, between(floor, left).f12 + between(floor, right).f12,
                  1e-12);
  const Vec3 x{0.5, 1.5, 0}, up{0, 0, 1};
  expect_relative(point_to_polygon(x, up, u),
                  point_to_polygon(x, up, left) + point_to_polygon(x, up, right), 1e-12);
}

// The row of each face of a closed convex room sums to 1.
void expect_closed(const std::vector<Polygon>& faces) {
  for (std::size_t i = 0; i < faces.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < faces.size(); ++j)
      if (i != j) sum += between(faces[i], faces[j]).f12;
    EXPECT_NEAR(sum, 1, 1e-9) << "face " << i;
  }
}

std::vector<Polygon> box_room(const Vec3& s) {
  return {{{0, 0, 0}, {s.x, 0, 0}, {s.x, s.y, 0}, {0, s.y, 0}},
          {{0, 0, s.z}, {0, s.y, s.z}, {s.x, s.y, s.z}, {s.x, 0, s.z}},
          {{0, 0, 0}, {0, 0, s.z}, {s.x, 0, s.z}, {s.x, 0, 0}},
          {{0, s.y, 0}, {s.x, s.y, 0}, {s.x, s.y, s.z}, {0, s.y, s.z}},
          {{0, 0, 0}, {0, s.y, 0}, {0, s.y, s.z}, {0, 0, s.z}},
          {{s.x, 0, 0}, {s.x, 0, s.z}, {s.x, s.y, s.z}, {s.x, s.y, 0}}};
}

TEST(FormFactor, RowsOfClosedRoomsSumToOne) {
  expect_closed(box_room({1, 1, 1}));
  expect_closed(box_room({40, 2, 0.05}));
  auto turned = box_room({4, 3, 2});
  for (Polygon& p : turned) p = rotated(p, {1, 2, 3}, 0.7);
  expect_closed(turned);
  const Vec3 a{0, 0, 0}, b{1, 0, 0}, c{0.2, 1.3, 0}, d{0.3, 0.4, 0.8};
  expect_closed({{a, b, c}, {a, d, b}, {b, d, c}, {c, d, a}});
}

// In an L-shaped room the square at the elbow sees everything: its floor's row sums to 1 with the
// concave ceiling and the walls at the reentrant corner, and so do its points'.
TEST(FormFactor, RowOfTheElbowOfAnLShapedRoomSumsToOne) {
  const std::vector<Vec2> plan{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  constexpr double kHeight = 0.8;
  std::vector<Polygon> faces(1);
  for (const Vec2& c : plan) faces[0].push_back({c.x, c.y, kHeight});
  faces[0] = flipped(faces[0]);
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Vec2 &c = plan[i], &d = plan[(i + 1) % plan.size()];
    faces.push_back({{c.x, c.y, 0}, {c.x, c.y, kHeight}, {d.x, d.y, kHeight}, {d.x, d.y, 0}});
    std::swap(faces.back()[1], faces.back()[3]);
    faces.back() = flipped(faces.back());
  }
  // Faces looking into the room: the elbow's middle is in front of every one.
  for (Polygon& face : faces)
    if (plane_of(face).distance({0.5, 0.5, 0.4}) < 0) face = flipped(face);
  double sum = 0;
  for (const Polygon& face : faces) sum += between(level(1, 1, 0), face).f12;
  EXPECT_NEAR(sum, 1, 1e-9);
  for (const double x : {1e-6, 0.3, 0.999999}) {
    double at_point = 0;
    for (const Polygon& face : faces) at_point += point_to_polygon({x, 0.4, 0}, {0, 0, 1}, face);
    EXPECT_NEAR(at_point, 1, 1e-13);
  }
}

// ---- what must not matter

TEST(FormFactor, OrderOfCornersTurnScaleAndPlaceDoNotMatter) {
  // Dyadic corners: shifting them by 2^20 rounds nothing.
  const Polygon p = level(1, 0.75, 0);
  const Polygon q{{0.25, 0, 0}, {0.25, 1.5, 0.5}, {-0.25, 1.5, 1.5}, {-0.25, 0, 1}};
  const PolygonFormFactors f = between(p, q);
  EXPECT_GT(f.f12, 0.05);
  for (std::size_t k = 1; k < 4; ++k) {
    Polygon r = p;
    std::rotate(r.begin(), r.begin() + std::ptrdiff_t(k), r.end());
    expect_relative(between(r, q).f12, f.f12, 1e-12);
  }
  for (const double scale : {1e-6, 1e-3, 1e4, 1e9})
    expect_relative(between(moved(p, scale, Vec3{0}), moved(q, scale, Vec3{0})).f12, f.f12, 1e-11);
  const Vec3 offset = 1048576.0 * Vec3{1, -1, 2};
  expect_relative(between(moved(p, 1, offset), moved(q, 1, offset)).f12, f.f12, 1e-9);
  for (const double turn : {0.1, 1.0, 3.0})
    expect_relative(between(rotated(p, {1, 2, 3}, turn), rotated(q, {1, 2, 3}, turn)).f12, f.f12,
                    1e-11);
  // Corners along an edge, and one twice.
  Polygon more = p;
  more.insert(more.begin() + 1, {{0.25, 0, 0}, {0.5, 0, 0}, {0.5, 0, 0}});
  expect_relative(between(more, q).f12, f.f12, 1e-12);

  const Vec3 x{0.5, 0.5, 0}, up{0, 0, 1};
  expect_relative(point_to_polygon(x + offset, up, moved(q, 1, offset)), point_to_polygon(x, up, q),
                  1e-12);
  expect_relative(point_to_polygon(x * 1e-6, up, moved(q, 1e-6, Vec3{0})),
                  point_to_polygon(x, up, q), 1e-12);
}

// ---- on corners, edges and in planes

TEST(PointFormFactor, FiniteEverywhere) {
  const Polygon w{{0, 0, -1}, {0, 1, -1}, {0, 1, 1}, {0, 0, 1}};
  for (const double x : {-1e-9, 0.0, 1e-300, 1e-17, 1e-9, 1.0})
    for (const double y : {-1.0, 0.0, 1e-12, 0.5, 1.0, 2.0})
      for (const double z : {-2.0, -1.0, 0.0, 0.5, 1.0, 2.0})
        for (const Vec3& n : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0},
                              normalize(Vec3{-1, 1, 1})}) {
          const double c = point_to_polygon({x, y, z}, n, w);
          EXPECT_TRUE(c >= 0 && c <= 1) << x << " " << y << " " << z << ": " << c;
          if (x < 0) {
            EXPECT_LT(c, 1e-8);
          }
        }
}

// Small, far, grazing and cut by the horizon: where the contour cancels, and where it does not.
TEST(PointFormFactor, InASumItIsAsNearAsASumCanTell) {
  constexpr double kAbsolute = 1e-13;
  const Vec3 up{0, 0, 1};
  int cancelled = 0;
  for (const double size : {1e-5, 1e-3, 0.3, 4.0})
    for (const double far : {0.2, 7.0, 900.0})
      for (const double height : {-1e-9, 0.0, 1e-6, 0.01, 2.0}) {
        const Vec3 a{far, 0.1, height};
        const Polygon q{a, a + size * Vec3{0, 0, 1}, a + size * Vec3{0, 1, 1}, a + size * Vec3{0, 1, 0}};
        const double exact = point_to_polygon({0, 0, 0}, up, q);
        cancelled += exact > 0 && exact < 1e-9;
        EXPECT_NEAR(point_to_polygon_in_sum({0, 0, 0}, up, q), exact, kAbsolute)
            << size << " " << far << " " << height;
      }
  EXPECT_GT(cancelled, 5);
}

// On the hinge of two half-planes' middle: (1 + cos angle) / 2, whatever is nearby small.
TEST(PointFormFactor, OnTheSharedEdgeItIsTheLimit) {
  for (const double angle : {30.0, 90.0, 150.0}) {
    const double a = angle * kPi / 180, c = std::cos(a), s = std::sin(a);
    constexpr double kFar = 1e5;
    const Polygon leaning{
        {0, -kFar, 0}, {0, kFar, 0}, {kFar * c, kFar, kFar * s}, {kFar * c, -kFar, kFar * s}};
    EXPECT_NEAR(point_to_polygon({0, 0, 0}, {0, 0, 1}, leaning), (1 + c) / 2, 1e-6);
    EXPECT_NEAR(point_to_polygon({1e-7, 0, 0}, {0, 0, 1}, leaning), (1 + c) / 2, 1e-6);
    // At the end of the hinge half as much: one of the two quarter-planes of floor is gone.
    const Polygon half{
        {0, 0, 0}, {0, kFar, 0}, {kFar * c, kFar, kFar * s}, {kFar * c, 0, kFar * s}};
    EXPECT_NEAR(point_to_polygon({0, 0, 0}, {0, 0, 1}, half), (1 + c) / 4, 1e-6);
  }
}

TEST(PointFormFactor, UnderALidAlmostTouching) {
  const Polygon lid = flipped(level(1, 1, 0));
  for (const double gap : {1e-15, 1e-12, 1e-9, 1e-6}) {
    EXPECT_NEAR(point_to_polygon({0.3, 0.6, -gap}, {0, 0, 1}, lid), 1, 1e-12 + 10 * gap);
    EXPECT_EQ(point_to_polygon({0.3, 0.6, gap}, {0, 0, 1}, lid), 0);
  }
  EXPECT_EQ(point_to_polygon({0.3, 0.6, 0}, {0, 0, 1}, lid), 0);
  EXPECT_EQ(point_to_polygon({0.3, 0.6, 0}, {0, 0, -1}, lid), 0);
}

// ---- input

TEST(FormFactor, RefusesWhatIsNoSimplePlanarPolygon) {
  const Polygon good = flipped(level(1, 1, 1));
  const auto cause = [&](const Polygon& bad) {
    const auto first = polygon_to_polygon(bad, good), second = polygon_to_polygon(good, bad);
    EXPECT_FALSE(first.ok());
    EXPECT_FALSE(second.ok());
    EXPECT_EQ(first.status().code(), Code::kUsage);
    EXPECT_EQ(first.status().file(), "polygon 1");
    EXPECT_EQ(second.status().file(), "polygon 2");
    EXPECT_EQ(first.status().cause(), second.status().cause());
    return first.status().cause();
  };
  EXPECT_EQ(cause({{0, 0, 0}, {1, 0, 0}}), "has fewer than three corners");
  EXPECT_EQ(cause({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}), "has no area");
  EXPECT_EQ(cause({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}), "has no area");
  EXPECT_EQ(cause({{0, 0, 0}, {1, 0, 0}, {1, 1, 0.01}, {0, 1, 0}}), "is not planar");
  EXPECT_EQ(cause({{0, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1, -1, 0}}), "crosses itself");
  EXPECT_EQ(cause({{0, 0, 0}, {NAN, 0, 0}, {0, 1, 0}}), "has a corner that is not finite");
  // A strip of 1 : 1e6 is a polygon.
  EXPECT_TRUE(polygon_to_polygon(level(1e6, 1, 0), good).ok());
}

TEST(FormFactor, ReadsPolygonsStrictly) {
  const auto p = parse_polygon(" 0 0 0;1\t0 0 ;-1e0 .5 1.25");
  ASSERT_TRUE(p.ok());
  EXPECT_EQ(*p, (Polygon{{0, 0, 0}, {1, 0, 0}, {-1, 0.5, 1.25}}));
  for (const char* bad : {"", ";", "0 0 0", "0 0 0;1 0 0", "0 0 0;1 0 0;0 1", "0 0 0;1 0 0;0 1 0;",
                          "0 0 0;1 0 0;0 1 0 0", "0 0 0;1 0 0;0 1 x", "0 0 0;1 0 0;0 1 nan",
                          "0 0 0;1 0 0;0 1 inf", "0 0 0;1 0 0;0 1 1e999", "0 0 0;1 0 0;0 1-1",
                          "0,0,0;1,0,0;0,1,0", "0 0 0;1 0 0;0 1 0x1p3"}) {
    const auto q = parse_polygon(bad);
    EXPECT_FALSE(q.ok()) << bad;
    if (!q.ok()) {
      EXPECT_EQ(q.status().code(), Code::kUsage);
    }
  }
  const auto point = parse_point("1 2 3;0 0 2");
  ASSERT_TRUE(point.ok());
  EXPECT_EQ((*point).x, (Vec3{1, 2, 3}));
  EXPECT_EQ((*point).normal, (Vec3{0, 0, 1}));
  for (const char* bad : {"1 2 3", "1 2 3;0 0 0", "1 2 3;0 0 1;0 0 1", "1 2 3;0 0"})
    EXPECT_FALSE(parse_point(bad).ok()) << bad;
}

TEST(Triangulate, ConcavePolygonsKeepTheirArea) {
  const Polygon comb{{0, 0, 0}, {5, 0, 0}, {5, 3, 0}, {4, 3, 0}, {4, 1, 0}, {3, 1, 0},
                     {3, 3, 0}, {2, 3, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}};
  // A square with a square hole, joined to the rim by a bridge there and back.
  const Polygon frame{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                      {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  for (const Polygon& p : {comb, frame}) {
    std::vector<Triangle> triangles;
    ASSERT_TRUE(triangulate(p, triangles));
    double sum = 0;
    for (const Triangle& t : triangles) sum += dot(area_vector(PolygonView(t)), Vec3{0, 0, 0.5});
    EXPECT_NEAR(sum, area(p), 1e-12);
  }
  // A lamp behind the frame: what the rim gives and what the hole lets by are the whole.
  const Polygon lamp = moved(flipped(level(1, 1, 0)), 1, {1.5, 1.5, 2});
  const Polygon hole = moved(level(2, 2, 0), 1, {1, 1, 0});
  expect_relative(between(lamp, frame).f12 + between(lamp, hole).f12,
                  between(lamp, level(4, 4, 0)).f12, 1e-12);
}

}  // namespace
}  // namespace atrium
