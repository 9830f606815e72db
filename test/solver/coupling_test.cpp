// Coupling coefficients against form factors of whole polygons and against brute quadrature of the
// kernel.
#include "solver/coupling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numbers>

#include "solver/form_factor.h"
#include "solver/outline.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

// coupling.cpp takes the kernel at the nodes where the source is farther than this many radii, as
// being within a thousandth of the closed form there.
constexpr double kThousandth = 1e-3;

// The inside of a cube: six faces, normals inward.
std::vector<Polygon> cube(double edge) {
  const Vec3 x{edge, 0, 0}, y{0, edge, 0}, z{0, 0, edge}, o{0};
  return {parallelogram(o, x, y), parallelogram(z, y, x), parallelogram(o, y, z),
          parallelogram(x, z, y), parallelogram(o, z, x), parallelogram(y, x, z)};
}

// All leaves of some trees as sites.
std::vector<Site> sites_of(const std::vector<PatchTree>& trees) {
  std::vector<Site> sites;
  for (const PatchTree& t : trees)
    for (std::size_t i = 0; i < t.elements.size(); ++i)
      if (t.elements[i].leaf()) sites.push_back(make_site(t.view(), i));
  return sites;
}

std::vector<Site> cube_of_elements(double edge, std::size_t leaves_a_face) {
  Patches patches(2);
  for (const Polygon& face : cube(edge)) patches.add(face);
  std::vector<PatchTree> trees = patches.trees();
  for (PatchTree& t : trees) grow(t, 2 * leaves_a_face - 1);
  return sites_of(trees);
}

double k00(const Site& r, const Site& s) {
  float out[9];
  couple(r, s, make_kernel(r, s), 1, out);
  return out[0];
}

// Unit squares that face each other.
std::array<PatchTree, 2> floor_and_ceiling(int order, double height) {
  Patches patches(order);
  const PatchId floor = patches.add(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const PatchId ceiling = patches.add(parallelogram({0, 0, height}, {0, 1, 0}, {1, 0, 0}));
  return {patches.tree(floor), patches.tree(ceiling)};
}

// A row of a closed room sums to 1: every node's directions all end on some element.
TEST(Coupling, RowsOfAClosedCubeSumToOne) {
  for (const std::size_t leaves : {1u, 4u, 16u, 64u}) {
    const std::vector<Site> sites = cube_of_elements(3, leaves);
    ASSERT_EQ(sites.size(), 6 * leaves);
    for (const Site& r : sites) {
      double sum = 0;
      for (const Site& s : sites) sum += k00(r, s);
      EXPECT_NEAR(sum, 1, kThousandth) << leaves << " elements a face";
    }
  }
}

bool far_apart(const Site& a, const Site& b, double radii) {
  return length(a.center - b.center) > radii * (a.radius + b.radius);
}

// A_r K00(r, s) = A_s K00(s, r). Where both ends are far from each other the sums are the same.
TEST(Coupling, ReciprocalBetweenElementsOfACube) {
  const std::vector<Site> sites = cube_of_elements(1, 16);
  int far = 0;
  for (const Site& r : sites)
    for (const Site& s : sites) {
      const double there = r.area * k00(r, s), back = s.area * k00(s, r);
      // Both nodes' distances exceed 4 radii: two sums of the same 16 products, rounded to float.
      if (far_apart(r, s, 3)) {
        EXPECT_NEAR(there, back, 1e-6 * there);
        far += there > 0;
      } else if (far_apart(r, s, 1)) {
        // Each is the mean of four exact values of a smooth function: Gauss's error.
        EXPECT_NEAR(there, back, 0.01 * std::max(there, back));
      } else {
        // Elements that touch: the configuration factor falls steeply from the common edge.
        EXPECT_NEAR(there, back, 0.12 * std::max(there, back));
      }
    }
  EXPECT_GT(far, 100);
}

// Against the double integral, pair by pair.
TEST(Coupling, EqualsTheFormFactorOfThePolygons) {
  const std::vector<Site> sites = cube_of_elements(1, 16);
  double far = 0, near = 0, touching = 0;
  for (std::size_t i = 0; i < sites.size(); i += 3)
    for (const Site& s : sites) {
      const Site& r = sites[i];
      const double k = k00(r, s);
      if (dot(r.normal, s.center - r.center) < 1e-9 || dot(s.normal, r.center - s.center) < 1e-9) {
        EXPECT_EQ(k, 0);
        continue;
      }
      const double f = polygon_to_polygon(r.polygon(), s.polygon()).value().f12;
      const double off = std::abs(k - f) / f;
      double& worst = far_apart(r, s, 3) ? far : far_apart(r, s, 1) ? near : touching;
      worst = std::max(worst, off);
    }
  EXPECT_LT(far, kThousandth);
  EXPECT_LT(near, 0.02);
  EXPECT_LT(touching, 0.12);
}

// One receiver node sees a source: the closed form where it is near, the nodes where it is far; at
// the border between the two the nodes are good to a thousandth, from straight above and aslant.
TEST(Coupling, NodesAreAsGoodAsTheClosedFormBeyondFourRadii) {
  Patches patches(2);
  const Polygon square = parallelogram({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const PatchId source = patches.add(square);
  const double far = 4.05 * std::sqrt(2.0);
  for (const double degrees : {0.0, 20.0, 40.0, 60.0}) {
    const double a = degrees * std::numbers::pi / 180;
    const Vec3 d{std::sin(a), 0, std::cos(a)};
    const Vec3 u{0, 1e-4, 0}, v = 1e-4 * cross(-d, Vec3{0, 1, 0});
    const PatchId receiver = patches.add(parallelogram(far * d, u, v));
    const PatchTree r = patches.tree(receiver), s = patches.tree(source);
    const Site rs = make_site(r.view(), 0), ss = make_site(s.view(), 0);
    ASSERT_NEAR(length(rs.normal - (-d)), 0, 1e-9);
    const double exact = point_to_polygon(rs.center, rs.normal, square);
    EXPECT_NEAR(make_kernel(rs, ss).center, exact, kThousandth * exact) << degrees << " degrees";
  }
}

// K_ab = (1/A_r) ∫∫ φa(x) φb(y) cosθ cosθ' / πr² dy dx, by 10^4 node pairs and more.
void expect_brute_quadrature(const Polygon& receiver, const Polygon& source, int order,
                             double tolerance) {
  Patches patches(order);
  const PatchId r = patches.add(receiver), s = patches.add(source);
  const PatchTree tr = patches.tree(r), ts = patches.tree(s);
  const Site a = make_site(tr.view(), 0), b = make_site(ts.view(), 0);
  const PatchView vr = tr.view(), vs = ts.view();
  const int n = vr.k();
  std::vector<float> k(n * n);
  couple(a, b, make_kernel(a, b), order, k);
  ASSERT_GT(k[0], 0.03);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const auto at = [&](const Vec2& p) {
        const Vec3 x = vr.point(p);
        const double inner = integrate(vs.polygon(ts.elements[0]), 1, [&](const Vec2& q) {
          const Vec3 d = vs.point(q) - x;
          const double c = dot(a.normal, d) * -dot(b.normal, d);
          return c / (std::numbers::pi * std::pow(dot(d, d), 2)) *
                 evaluate_basis(vs.basis_of(0), ts.elements[0], order, q)[j];
        });
        return inner * evaluate_basis(vr.basis_of(0), tr.elements[0], order, p)[i];
      };
      const double expected = integrate(vr.polygon(tr.elements[0]), 1, at) / tr.elements[0].area;
      EXPECT_NEAR(k[n * i + j], expected, tolerance * k[0]) << i << ", " << j;
    }
}

const Polygon kFlat = parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1.2, 0});
const Polygon kAslant = parallelogram({.2, -.3, 2}, {0, 1, .3}, {1, .1, .4});  // above, facing down

TEST(Coupling, HigherCoefficientsEqualBruteQuadrature) {
  expect_brute_quadrature(kFlat, kAslant, 2, 0.005);
}

// Nodes of degree 5 take a quartic for part of a quadratic. Of elements of radius .78, 2 apart, a
// kernel's quartic part is some (.78 / 2)⁴ = .023 of it times its coefficient in the binomial series,
// taken as 1/8. In a pentagon, whose nodes are of degree 2, cubics are taken for more too.
TEST(Coupling, QuadraticCoefficientsEqualBruteQuadrature) {
  const Polygon pentagon{{0, 0, 0}, {1, 0, 0}, {1.1, .6, 0}, {.5, 1.2, 0}, {-.1, .7, 0}};
  const Polygon triangle{{0, 0, 2}, {.3, 1.1, 2.2}, {1, .2, 2.1}};
  const Polygon crooked{{0, 0, 2}, {-.1, 1, 2}, {.8, 1.2, 2}, {1, .1, 2}};
  expect_brute_quadrature(kFlat, kAslant, 3, 0.003);
  expect_brute_quadrature(kFlat, triangle, 3, 0.003);
  expect_brute_quadrature(kFlat, crooked, 3, 0.003);
  expect_brute_quadrature(pentagon, triangle, 3, 0.004);
  expect_brute_quadrature(pentagon, crooked, 3, 0.004);
}

TEST(Coupling, NothingFromBehindAndNothingWithinAPlane) {
  Patches patches(2);
  const PatchId floor = patches.add(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const PatchId beside = patches.add(parallelogram({1, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const PatchId below = patches.add(parallelogram({0, 0, -1}, {1, 0, 0}, {0, 1, 0}));
  const PatchId turned_away = patches.add(parallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}));
  const PatchTree r = patches.tree(floor);
  const Site site = make_site(r.view(), 0);
  for (const PatchId other : {beside, below, turned_away}) {
    const PatchTree s = patches.tree(other);
    EXPECT_EQ(k00(site, make_site(s.view(), 0)), 0);
  }
}

// Visibility enters pair by pair: two complementary masks add up to all.
TEST(Coupling, MasksAddUp) {
  const auto [r, s] = floor_and_ceiling(2, 1);
  const Site a = make_site(r.view(), 0), b = make_site(s.view(), 0);
  const Kernel kernel = make_kernel(a, b);
  float all[9], none[9], some[9], rest[9];
  couple(a, b, kernel, 2, all);
  constexpr VisibleMask kAll = 0xffff, kSome = 0x5a1c;
  couple(a, b, masked(a, b, kernel, kAll, 0), 2, none);
  couple(a, b, masked(a, b, kernel, kAll, kSome), 2, some);
  couple(a, b, masked(a, b, kernel, kAll, VisibleMask(~kSome)), 2, rest);
  EXPECT_GT(some[0], 0);
  EXPECT_GT(rest[0], 0);
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(none[i], 0);
    EXPECT_NEAR(some[i] + rest[i], all[i], 1e-6 * all[0]);
  }
}

// Sixteen segments between four eyes on either side stand for all node pairs: a blocker that hides
// one half of the receiver's eyes hides about that half of its nodes, and all of it nothing else.
TEST(Coupling, NodesSeeWhatTheEyesAboutThemSee) {
  const auto [r, s] = floor_and_ceiling(3, 9);
  const Site a = make_site(r.view(), 0), b = make_site(s.view(), 0);
  const Kernel open = make_kernel(a, b);
  const VisibleMask all = facing_lanes(a, b, open);
  ASSERT_EQ(all, 0xffff);
  VisibleMask left = 0;
  for (int k = 0; k < a.eyes; ++k)
    for (int l = 0; l < b.eyes; ++l)
      if (a.eye[k].x < 0.5) left |= lane(k, l);
  const Kernel seen = masked(a, b, open, all, left);
  EXPECT_NEAR(seen.mean, 0.5 * open.mean, 1e-3 * open.mean);  // the square's symmetry
  for (int k = 0; k < seen.rows; ++k) {
    // In the middle half; at the side nodes, three to one in the distance to the fourth power and
    // more.
    const double x = a.x[k].x, share = seen.row[k] / open.row[k];
    EXPECT_NEAR(share, std::abs(x - 0.5) < 1e-9 ? 0.5 : x < 0.5 ? 1 : 0, 0.08) << k;
  }
  const Kernel whole = masked(a, b, open, all, all), none = masked(a, b, open, all, 0);
  EXPECT_EQ(whole.mean, open.mean);
  EXPECT_EQ(none.mean, 0);
}

// A floor and a ceiling of one metre, a sheet of 0.4 × 0.5 half way: a point of either sees of the
// other what the sheet's shadow, twice its size, leaves of it.
TEST(Coupling, PastASheetEachNodeSeesWhatItsShadowLeaves) {
  const auto [r, s] = floor_and_ceiling(2, 1);
  const Site floor = make_site(r.view(), 0), ceiling = make_site(s.view(), 0);
  const Polygon sheet = parallelogram({.3, .2, .5}, {.4, 0, 0}, {0, .5, 0});
  const std::vector<BlockerPolygon> all{{sheet, 0}};
  const std::vector<std::uint32_t> positions{0};
  const BlockerList blockers{positions, all, 1e-9};
  const Kernel open = make_kernel(floor, ceiling);

  // Of the unit square at the other height; its corners, and those of the shadow, clipped to it.
  const auto seen_from = [&](const Vec3& x, const Vec3& n, double height) {
    const auto facing = [&](Vec2 lo, Vec2 hi) {
      Polygon p{
          {lo.x, lo.y, height}, {hi.x, lo.y, height}, {hi.x, hi.y, height}, {lo.x, hi.y, height}};
      if (height > 0) std::reverse(p.begin(), p.end());
      return p;
    };
    const Vec2 at{x.x, x.y}, zero{0}, one{1};
    const Vec2 lo = glm::max(zero, 2.0 * Vec2{.3, .2} - at);
    const Vec2 hi = glm::min(one, 2.0 * Vec2{.7, .7} - at);
    return point_to_polygon(x, n, facing(zero, one)) - point_to_polygon(x, n, facing(lo, hi));
  };
  const Kernel by_floor = seen_by_receiver(floor, ceiling, open, blockers).value();
  for (int k = 0; k < by_floor.rows; ++k)
    EXPECT_NEAR(by_floor.row[k], seen_from(floor.x[k], {0, 0, 1}, 1), 1e-7) << k;
  EXPECT_NEAR(by_floor.center, seen_from(floor.center, {0, 0, 1}, 1), 1e-7);

  const Kernel by_ceiling = seen_by_source(floor, ceiling, open, blockers).value();
  for (int l = 0; l < by_ceiling.columns; ++l) {
    double column = 0;
    for (int k = 0; k < by_ceiling.rows; ++k) column += floor.weight[k] * by_ceiling.g[k][l];
    EXPECT_NEAR(column, ceiling.weight[l] * seen_from(ceiling.x[l], {0, 0, -1}, 0), 1e-7) << l;
  }
  EXPECT_NEAR(by_floor.mean, by_ceiling.mean, 0.02 * open.mean);  // two rules of four nodes
  EXPECT_LT(by_floor.mean, 0.7 * open.mean);                      // the sheet hides a good part
}

// The same in eight strips of the ceiling, across which the shadow's edges run: what a floor's node
// sees of them adds up to what it sees of the ceiling, be it much or little of each. That what the
// ceiling's nodes see of the floor does as well is up to where they happen to stand.
TEST(Coupling, WhatANodeSeesOfTheStripsOfACeilingAddsUp) {
  const auto [r, s] = floor_and_ceiling(2, 1);
  const Site floor = make_site(r.view(), 0), ceiling = make_site(s.view(), 0);
  const Polygon sheet = parallelogram({.3, -1, .5}, {.4, 0, 0}, {0, 3, 0});
  const std::vector<BlockerPolygon> all{{sheet, 0}};
  const std::vector<std::uint32_t> positions{0};
  const BlockerList blockers{positions, all, 1e-9};
  const Kernel whole =
      seen_by_receiver(floor, ceiling, make_kernel(floor, ceiling), blockers).value();
  constexpr int kStrips = 8;
  std::array<double, kMaxNodes> rows{};
  double by_ceiling = 0;
  for (int i = 0; i < kStrips; ++i) {
    Outline strip;
    for (const Vec2& at : {Vec2{0, 0}, Vec2{0, 1}, Vec2{1, 1}, Vec2{1, 0}})
      strip.push_back(s.head.frame.to_plane({(i + at.x) / kStrips, at.y, 1}));
    const Site part = make_site(s.view(), 0, strip);
    const Kernel open = make_kernel(floor, part);
    const Kernel seen = seen_by_receiver(floor, part, open, blockers).value();
    for (int k = 0; k < seen.rows; ++k) rows[k] += seen.row[k];
    by_ceiling += seen_by_source(floor, part, open, blockers).value().mean;
  }
  for (int k = 0; k < whole.rows; ++k) EXPECT_NEAR(rows[k], whole.row[k], 1e-7) << k;
  EXPECT_GT(std::abs(by_ceiling / whole.mean - 1), 0.01);
}

// Of a ceiling, half of which is hidden, a point sees the other half: the light comes from there,
// for what the ceiling's linear functions make of it.
TEST(Coupling, WhatIsSeenComesFromWhereItIsSeen) {
  Patches patches(2);
  const PatchTree r = patches.tree(patches.add(parallelogram({0, 0, 0}, {.01, 0, 0}, {0, .01, 0})));
  const PatchTree s = patches.tree(patches.add(parallelogram({-1, -1, 9}, {0, 2, 0}, {2, 0, 0})));
  const PatchTree h = patches.tree(patches.add(parallelogram({0, -1, 9}, {0, 2, 0}, {1, 0, 0})));
  const Site floor = make_site(r.view(), 0), ceiling = make_site(s.view(), 0);
  const Polygon sheet = parallelogram({-9, -9, 8.9}, {9, 0, 0}, {0, 18, 0});
  const std::vector<BlockerPolygon> all{{sheet, 0}};
  const std::vector<std::uint32_t> positions{0};
  const Kernel seen =
      seen_by_receiver(floor, ceiling, make_kernel(floor, ceiling), {positions, all, 1e-9}).value();
  double x = 0;
  for (int l = 0; l < seen.columns; ++l) x += seen.g[0][l] * ceiling.x[l].x;
  // 0.01/8.9 × 0.1 of parallax at the most; far away all of the half counts alike.
  EXPECT_NEAR(x / seen.row[0], 0.5, 2e-3);
  EXPECT_NEAR(seen.mean, make_kernel(floor, make_site(h.view(), 0)).mean, 1e-3 * seen.mean);
}

// A source cut in two sends what it sent whole, to the same basis functions of the whole.
TEST(Coupling, PartsOfASourceAddUpToIt) {
  for (const int order : {2, 3}) {
    const auto [r, s] = floor_and_ceiling(order, 3);
    const Site a = make_site(r.view(), 0), whole = make_site(s.view(), 0);
    const std::span<const Vec2> o = s.view().polygon(s.elements[0]);
    ASSERT_EQ(o.size(), 4u);
    const Vec2 m = 0.5 * (o[0] + o[1]), n = 0.5 * (o[2] + o[3]);
    const std::vector<Vec2> half1{o[0], m, n, o[3]}, half2{m, o[1], o[2], n};
    const int kk = r.view().k() * r.view().k();
    std::vector<float> all(kk), k1(kk), k2(kk);
    couple(a, whole, make_kernel(a, whole), order, all);
    const Site p1 = make_site(s.view(), 0, half1), p2 = make_site(s.view(), 0, half2);
    EXPECT_NEAR(p1.area, 0.5, 1e-14);
    couple(a, p1, make_kernel(a, p1), order, k1);
    couple(a, p2, make_kernel(a, p2), order, k2);
    for (int i = 0; i < kk; ++i) EXPECT_NEAR(k1[i] + k2[i], all[i], kThousandth * all[0]) << i;
  }
}

// Coefficients are shares: a room of 1e-6 m or 1e6 m has those of one of a metre.
TEST(Coupling, IndependentOfScale) {
  const std::vector<Site> metre = cube_of_elements(1, 4);
  for (const int exponent : {-20, 20}) {
    const std::vector<Site> other = cube_of_elements(std::ldexp(1.0, exponent), 4);
    ASSERT_EQ(other.size(), metre.size());
    for (std::size_t r = 0; r < metre.size(); ++r)
      for (std::size_t s = 0; s < metre.size(); ++s)
        EXPECT_NEAR(k00(other[r], other[s]), k00(metre[r], metre[s]), 1e-6);
  }
}

}  // namespace
}  // namespace atrium::testing
