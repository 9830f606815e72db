// Refinement: what links carry in the end is the light that geometry lets through, each part of it
// once, with nothing, something or all of it in the way.
#include "solver/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numbers>
#include <vector>

#include "engine/squared.h"
#include "solver/form_factor.h"
#include "solver/gather.h"
#include "test/solver/settings.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

// One source that sends 1 lm/m² to one receiver, blockers between.
struct Transfer {
  Polygon receiver, source;
  std::vector<Polygon> blockers;
  int order = 2;
};

struct Outcome {
  PatchTree tree;  // of the receiver, after push-pull
  LinkSet set;
  RefineCounters counters;
  double mean() const { return tree.e[0]; }  // E, which is the form factor
};

Outcome carry_out(const Transfer& t, const RefineSettings& settings) {
  Patches patches(t.order);
  const PatchId r = patches.add(t.receiver);
  std::vector<BlockerPolygon> blockers{{t.receiver, 0}, {t.source, 1}};
  for (const Polygon& b : t.blockers)
    blockers.push_back({b, static_cast<std::uint32_t>(blockers.size())});
  patches.add(t.source, {Spectrum{0}, Spectrum{1}});
  std::vector<PatchTree> trees = patches.trees();
  std::vector<PatchTree> sources{trees[1]};
  const Record record(0, sources);
  const ClusterView view = record.view();
  const SourceRoots roots(view);

  const BlockerIndex index(blockers);
  const RayScene rays(blockers);
  Outcome o;
  o.tree = trees[r.value];
  Refiner refiner(settings, t.blockers.empty() ? Surroundings{} : Surroundings{&index, &rays});
  refiner.link(o.tree, roots, o.set);
  refiner.flush();
  o.counters = refiner.counters();
  GatherSlots slots;
  slots.reset(o.tree.elements.size(), o.tree.view().k());
  RowMean mean;
  std::vector<SentDetail> details;
  const Braid braid = plait(ClusterId(0u), std::span(&o.set, 1));
  for (const Braid::Strand& strand : braid.strands)
    gather(braid, strand, {view, {}}, t.order, o.tree.elements, kNoCap, slots, mean, &details);
  push_pull(o.tree, slots, {});
  return o;
}

Polygon floor_square() { return parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}); }
// Faces down at height h.
Polygon ceiling_square(double h, double side = 1) {
  const double o = 0.5 - side / 2;
  return parallelogram({o, o, h}, {0, side, 0}, {side, 0, 0});
}
// Shares the floor's edge x = 0 and faces it.
Polygon wall_square() { return parallelogram({0, 0, 0}, {0, 1, 0}, {0, 0, 1}); }

double form_factor(const Polygon& a, const Polygon& b) {
  return polygon_to_polygon(a, b).value().f12;
}

// The error that a link may make is threshold × the mean irradiance (1 here) over √(its area's
// share): summed in squares over links of one receiver it stays of the order of the threshold.
TEST(Refine, UnoccludedTransfersAreFormFactors) {
  for (const int order : {1, 2, 3})
    for (const Transfer& t : {Transfer{floor_square(), ceiling_square(1), {}, order},
                              Transfer{floor_square(), ceiling_square(0.3, 0.4), {}, order},
                              Transfer{floor_square(), wall_square(), {}, order},
                              Transfer{floor_square(), ceiling_square(5, 8), {}, order}}) {
      const double exact = form_factor(t.receiver, t.source);
      for (const double threshold : {0.02, 0.002}) {
        const Outcome o = carry_out(t, settings_of(threshold));
        EXPECT_NEAR(o.mean(), exact, threshold) << "order " << order;
        EXPECT_GT(o.set.links.size() + o.set.thin.size(), 0u);
      }
    }
}

// Leaf by leaf: a hole or a doubling in the links would show on the leaves it concerns.
TEST(Refine, EveryLeafReceivesItsOwnFormFactor) {
  for (const Polygon& source : {ceiling_square(0.5), wall_square()}) {
    const Transfer t{floor_square(), source, {}, 2};
    const Outcome o = carry_out(t, settings_of(0.0005));
    EXPECT_GT(o.tree.elements.size(), 10u);
    for (std::size_t i = 0; i < o.tree.elements.size(); ++i) {
      const Element& x = o.tree.elements[i];
      if (!x.leaf()) continue;
      Polygon leaf;
      for (const Vec2& p : o.tree.view().polygon(x)) leaf.push_back(o.tree.view().point(p));
      const double e = o.tree.view().e_of(i)[0];
      // An error of 0.0005 weighed by √area, some of them to a leaf.
      EXPECT_NEAR(e, form_factor(leaf, source), 5 * 0.0005 / std::sqrt(x.area)) << "leaf " << i;
    }
  }
}

std::size_t leaf_count(const PatchTree& tree) {
  return static_cast<std::size_t>(
      std::ranges::count_if(tree.elements, [](const Element& x) { return x.leaf(); }));
}

// Root mean square over the receiver of E less what `exact` says, point by point.
template <class F>
double rms_error(const PatchTree& tree, const F& exact) {
  double sum2 = 0;
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    if (!tree.elements[i].leaf()) continue;
    sum2 += integrate(tree.view().polygon(tree.elements[i]), 2, [&](const Vec2& p) {
      return std::pow(value_at(tree, i, p, 0) - exact(tree.view().point(p)), 2);
    });
  }
  return std::sqrt(sum2 / tree.elements[0].area);
}

// A link's error times √(area) is below the threshold: over N leaves of 1 m² in all that makes
// √N × threshold, root mean square.
double allowed(const Outcome& o, double threshold) {
  return std::sqrt(double(leaf_count(o.tree))) * threshold;
}

TEST(Refine, ErrorFollowsTheThreshold) {
  const Transfer t{floor_square(), ceiling_square(0.5), {}, 2};
  double last = 1;
  for (const double threshold : {0.03, 0.01, 0.003, 0.001}) {
    const Outcome o = carry_out(t, settings_of(threshold));
    const double rms = rms_error(o.tree, [&](const Vec3& x) {
      return point_to_polygon(x, {0, 0, 1}, t.source);
    });
    EXPECT_LT(rms, allowed(o, threshold));
    EXPECT_LT(rms, last);
    last = rms;
  }
}

TEST(Refine, NothingPassesAWall) {
  const Polygon wall = parallelogram({-5, -5, 0.5}, {11, 0, 0}, {0, 11, 0});
  const Outcome o = carry_out({floor_square(), ceiling_square(1), {wall}, 2}, settings_of(0.001));
  EXPECT_EQ(o.set.links.size() + o.set.thin.size() + o.set.doubts.size(), 0u);
  EXPECT_EQ(o.mean(), 0);
}

// A box's lid, seen from inside, and a wall of the room that it stands in, of which a low strip
// alone is below the lid and no node is: what the lid sees is the box. Without the box it sees the
// strip.
TEST(Refine, FromInsideABoxNoWallOfTheRoomIsSeen) {
  constexpr double kLid = 0.4, kAway = 1.1, kHeight = 2.7;
  const Polygon lid = parallelogram({0, 0, kLid}, {0, 0.7, 0}, {0.7, 0, 0});  // it faces down
  const Polygon wall = parallelogram({0.7 + kAway, -1.5, 0}, {0, 0, kHeight}, {0, 3.7, 0});
  const Polygon strip = parallelogram({0.7 + kAway, -1.5, 0}, {0, 0, kLid}, {0, 3.7, 0});
  const std::vector<Polygon> sides{parallelogram({0, 0, 0}, {0.7, 0, 0}, {0, 0, kLid}),
                                   parallelogram({0.7, 0, 0}, {0, 0.7, 0}, {0, 0, kLid}),
                                   parallelogram({0, 0.7, 0}, {0.7, 0, 0}, {0, 0, kLid}),
                                   parallelogram({0, 0, 0}, {0, 0.7, 0}, {0, 0, kLid})};
  for (const double threshold : {0.02, 0.002}) {
    EXPECT_EQ(carry_out({lid, wall, sides, 2}, settings_of(threshold)).mean(), 0) << threshold;
    EXPECT_NEAR(carry_out({lid, wall, {}, 2}, settings_of(threshold)).mean(),
                form_factor(lid, strip), threshold);
  }
}

TEST(Refine, WhatStandsBesideDoesNotBlock) {
  const Polygon beside = parallelogram({1.2, -5, 0.5}, {11, 0, 0}, {0, 11, 0});
  const Transfer with{floor_square(), ceiling_square(1), {beside}, 2};
  Transfer without = with;
  without.blockers.clear();
  const Outcome a = carry_out(with, settings_of(0.002)), b = carry_out(without, settings_of(0.002));
  EXPECT_EQ(a.tree.e, b.tree.e);
  EXPECT_EQ(a.counters.rays, 0u);  // a shaft shows it
}

// What a floor point sees of a ceiling rectangle past a smaller rectangle that hangs parallel to
// it: the ceiling's part less what the other covers of it, seen from the point.
double past_a_sheet(const Vec3& x, const Vec2& source_lo, const Vec2& source_hi, double height,
                    const Vec2& sheet_lo, const Vec2& sheet_hi, double sheet_height) {
  const double scale = height / sheet_height;
  const auto project = [&](const Vec2& p) { return Vec2{x.x, x.y} + scale * (p - Vec2{x.x, x.y}); };
  const Vec2 a = glm::max(source_lo, project(sheet_lo)), b = glm::min(source_hi, project(sheet_hi));
  const auto facing_down = [&](const Vec2& lo, const Vec2& hi) {
    return Polygon{
        {lo.x, lo.y, height}, {lo.x, hi.y, height}, {hi.x, hi.y, height}, {hi.x, lo.y, height}};
  };
  const Vec3 up{0, 0, 1};
  double c = point_to_polygon(x, up, facing_down(source_lo, source_hi));
  if (a.x < b.x && a.y < b.y) c -= point_to_polygon(x, up, facing_down(a, b));
  return c;
}

// A rectangle in a plane of constant height, in n × n pieces.
std::vector<Polygon> pieces_of_a_sheet(const Vec2& lo, const Vec2& hi, double height, int n) {
  const Vec2 step = (hi - lo) / double(n);
  std::vector<Polygon> pieces;
  for (int i = 0; i < n * n; ++i)
    pieces.push_back(parallelogram({lo.x + i % n * step.x, lo.y + i / n * step.y, height},
                                   {step.x, 0, 0}, {0, step.y, 0}));
  return pieces;
}

// One sheet's shadow is measured, that of sixteen pieces of it seen by rays; both are what
// projection says. The sheet's edges line up with none of the floor's halves or quarters, as chance
// has it.
TEST(Refine, PenumbraOfASheetIsWhatProjectionSays) {
  const Vec2 lo{0.25, 0.25}, hi{0.75, 0.75}, sheet_lo{0.117, 0.313}, sheet_hi{0.523, 0.871};
  const double height = 1, sheet_height = 0.537;
  const auto exact = [&](const Vec3& x) {
    return past_a_sheet(x, lo, hi, height, sheet_lo, sheet_hi, sheet_height);
  };
  constexpr int kGrid = 64;
  double mean = 0;
  for (int i = 0; i < kGrid * kGrid; ++i)
    mean += exact({(i % kGrid + .5) / kGrid, (i / kGrid + .5) / kGrid, 0}) / (kGrid * kGrid);
  // The sheet hides a good part.
  ASSERT_LT(mean, 0.8 * form_factor(floor_square(), ceiling_square(height, 0.5)));
  for (const int n : {1, 4}) {
    const Transfer t{floor_square(), ceiling_square(height, 0.5),
                     pieces_of_a_sheet(sheet_lo, sheet_hi, sheet_height, n), 2};
    double last = 1;
    for (const double threshold : {0.03, 0.003, 0.0005}) {
      const Outcome o = carry_out(t, settings_of(threshold));
      const double rms = rms_error(o.tree, exact);
      EXPECT_NEAR(o.mean(), mean, threshold);
      // Against that much error rays will do; where it is little, what one sheet leaves is measured.
      const bool measured = 2 * o.counters.links_without_rays > o.counters.links;
      if (threshold == 0.03) {
        EXPECT_EQ(o.counters.links_without_rays, 0u);
      }
      if (n == 1) {
        EXPECT_EQ(measured, threshold == 0.0005);
      }
      EXPECT_LT(rms, allowed(o, threshold));
      EXPECT_LT(rms, last);
      last = rms;
    }
  }
}

// Through a window that leaves an eighth, wherever it is: what four blockers leave is measured
// where it weighs much.
TEST(Refine, WhatAWindowLeavesIsMeasured) {
  constexpr double kWindow = 0.35, kHeight = 0.5;
  constexpr int kPlaces = 20, kGrid = 8;
  double found = 0, exact = 0;
  std::uint64_t rays = 0, pairs = 0;
  for (int place = 0; place < kPlaces * kPlaces; ++place) {
    const Vec2 a = (1 - kWindow) / (kPlaces - 1) * Vec2{place % kPlaces, place / kPlaces};
    const Vec2 b = a + Vec2{kWindow};
    const std::vector<Polygon> frame{
        parallelogram({-1, -1, kHeight}, {1 + a.x, 0, 0}, {0, 3, 0}),
        parallelogram({b.x, -1, kHeight}, {2 - b.x, 0, 0}, {0, 3, 0}),
        parallelogram({a.x, -1, kHeight}, {kWindow, 0, 0}, {0, 1 + a.y, 0}),
        parallelogram({a.x, b.y, kHeight}, {kWindow, 0, 0}, {0, 2 - b.y, 0})};
    const Outcome o = carry_out({floor_square(), ceiling_square(1), frame, 2}, settings_of(0.0025));
    found += o.mean();
    rays += o.counters.rays;
    pairs += o.counters.kernels;
    for (int i = 0; i < kGrid * kGrid * kGrid * kGrid; ++i) {
      const auto at = [&](int k) { return (i / k % kGrid + .5) / kGrid; };
      const Vec2 x{at(1), at(kGrid)}, y{at(kGrid * kGrid), at(kGrid * kGrid * kGrid)};
      const Vec2 through = 0.5 * (x + y);
      if (through.x < a.x || through.x > b.x || through.y < a.y || through.y > b.y) continue;
      const double d2 = 1 + dot(y - x, y - x);
      exact += 1 / (std::numbers::pi * d2 * d2 * kGrid * kGrid * kGrid * kGrid);
    }
  }
  EXPECT_LT(rays, 16 * pairs);
  EXPECT_NEAR(found, exact, 0.06 * exact);
}

TEST(Refine, SameBitsEveryTime) {
  const Transfer t{floor_square(),
                   ceiling_square(1, 0.5),
                   {parallelogram({0.1, 0.3, 0.5}, {0.4, 0, 0}, {0, 0.6, 0})},
                   2};
  const Outcome a = carry_out(t, settings_of(0.003)), b = carry_out(t, settings_of(0.003));
  ASSERT_EQ(a.set.links.size(), b.set.links.size());
  EXPECT_EQ(0, std::memcmp(a.set.links.data(), b.set.links.data(),
                           a.set.links.size() * sizeof(LinkHead)));
  EXPECT_EQ(a.set.couplings, b.set.couplings);
  EXPECT_EQ(a.tree.e, b.tree.e);
}

// A lamp over a furnished floor: a table's top, a screen, a shelf of three boards, a box. What each
// point receives is what 1,024 segments to the lamp say, kernel by kernel; and it took less than
// half of sixteen rays for each pair looked at.
TEST(Refine, FurnishedRoomNeedsFewRays) {
  const Polygon floor = parallelogram({0, 0, 0}, {4, 0, 0}, {0, 4, 0});
  const Vec3 corner{1.6, 1.4, 2.5};
  const Polygon lamp = parallelogram(corner, {0, 1, 0}, {.8, 0, 0});
  std::vector<Polygon> furniture{parallelogram({.5, 1.1, .7}, {1.3, 0, 0}, {0, .8, 0}),
                                 parallelogram({2.9, .4, 0}, {.5, 1.1, 0}, {0, 0, 1.6}),
                                 parallelogram({2.2, 2.4, .4}, {.5, 0, 0}, {0, .5, 0}),
                                 parallelogram({2.2, 2.4, 0}, {.5, 0, 0}, {0, 0, .4}),
                                 parallelogram({2.2, 2.9, 0}, {.5, 0, 0}, {0, 0, .4}),
                                 parallelogram({2.2, 2.4, 0}, {0, .5, 0}, {0, 0, .4}),
                                 parallelogram({2.7, 2.4, 0}, {0, .5, 0}, {0, 0, .4})};
  for (const double z : {.3, .8, 1.3})
    furniture.push_back(parallelogram({.3, 3.2, z}, {1.1, 0, 0}, {0, .4, 0}));
  std::vector<Plane> planes;
  for (const Polygon& p : furniture) planes.push_back(plane_of(p));
  const auto open = [&](const Vec3& x, const Vec3& y) {
    for (std::size_t i = 0; i < furniture.size(); ++i) {
      const double a = planes[i].distance(x), b = planes[i].distance(y);
      if (a * b < 0 && contains(furniture[i], planes[i].normal, x + (y - x) * (a / (a - b)), 0))
        return false;
    }
    return true;
  };
  const auto exact = [&](const Vec3& x) {
    constexpr int kSide = 32;
    double sum = 0;
    for (int i = 0; i < kSide * kSide; ++i) {
      const Vec3 y = corner + Vec3{.8 * (i % kSide + .5) / kSide, (i / kSide + .5) / kSide, 0};
      const double d2 = dot(y - x, y - x);
      if (open(x, y)) sum += squared(y.z - x.z) / (std::numbers::pi * d2 * d2);
    }
    return .8 * sum / (kSide * kSide);
  };
  RefineSettings settings = settings_of(5e-5);
  settings.min_edge = 0.02;
  const Outcome o = carry_out({floor, lamp, furniture, 2}, settings);

  constexpr int kGrid = 24;
  double error2 = 0, mean = 0, all2 = 0;
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const Vec3 x{4 * (i % kGrid + .37) / kGrid, 4 * (i / kGrid + .61) / kGrid, 0};
    const Vec2 p = o.tree.head.frame.to_plane(x);
    std::size_t at = 0;
    while (!o.tree.elements[at].leaf()) {
      const std::size_t child = o.tree.elements[at].child;
      at = inside(o.tree.view().polygon(o.tree.elements[child]), p, 0) ? child : child + 1;
    }
    const double e = exact(x);
    error2 += squared(value_at(o.tree, at, p, 0) - e) / (kGrid * kGrid);
    all2 += squared(e) / (kGrid * kGrid);
    mean += e / (kGrid * kGrid);
  }
  EXPECT_LT(mean, 0.9 * form_factor(floor, lamp));  // the furniture hides a good part of the floor
  EXPECT_NEAR(o.mean(), mean, 0.02 * mean);
  EXPECT_LT(std::sqrt(error2), 0.06 * std::sqrt(all2));
  EXPECT_LT(2 * o.counters.rays, 16 * o.counters.kernels);
  EXPECT_GT(o.counters.links_without_rays, o.counters.links / 3);
}

// Tables over the Gauss nodes of a floor hide every segment from node to node, not the floor. What
// is seen of it from above, by a grid of rays that knows no nodes, is a good part.
TEST(Refine, TablesOverTheNodesDoNotHideTheFloor) {
  std::vector<Polygon> tables;
  for (const double x : {0.2113, 0.7887})
    for (const double y : {0.2113, 0.7887})
      tables.push_back(parallelogram({x - .1, y - .1, 0.02}, {.2, 0, 0}, {0, .2, 0}));
  const Transfer t{floor_square(), ceiling_square(1), tables, 2};
  const Outcome o = carry_out(t, settings_of(0.002));
  // The tables cover 16% of the floor so closely that all above them is lost, and little beside.
  const double open = form_factor(t.receiver, t.source);
  EXPECT_NEAR(o.mean(), 0.84 * open, 0.04 * open);
}

// A panel of 0.6 m two hundredths below a ceiling: what the ceiling receives is the closed form's,
// on the spot, at its rim and in all, though the panel's nodes see no rim and the ceiling's no
// spot.
// A box of 1 m × 1 m stands on a lit floor of 4 m × 4 m. Before a link is made the floor is split
// along its foot, which no chord of the floor follows; where it is dark already nothing is.
TEST(Refine, LitFloorIsSplitAlongTheFootOfABox) {
  const Vec2 lo{1.3, 1.7}, hi{2.3, 2.7};
  const std::array<Vec3, 4> foot{Vec3{lo.x, lo.y, 0}, {hi.x, lo.y, 0}, {hi.x, hi.y, 0},
                                 {lo.x, hi.y, 0}};
  std::vector<Contact> contacts;
  for (std::size_t i = 0; i < 4; ++i) contacts.push_back({foot[i], foot[(i + 1) % 4]});
  Patches patches(2);
  const PatchId floor = patches.add(parallelogram({0, 0, 0}, {4, 0, 0}, {0, 4, 0}), {}, contacts);
  PatchTree lit = patches.tree(floor), dark = patches.tree(floor);
  for (int c = 0; c < kChannels; ++c) lit.e[std::size_t(c)] = 1;  // the scale of errors
  for (PatchTree* tree : {&lit, &dark})
    Refiner(settings_of(0.001), Surroundings{}).cut_at_contacts(*tree);
  EXPECT_EQ(dark.elements.size(), 1u);
  double under = 0, across = 0;
  for (const Element& x : lit.elements) {
    if (!x.leaf()) continue;
    int corners = 0;
    for (const Vec2& p : lit.view().polygon(x)) {
      const Vec3 at = lit.view().point(p);
      corners += at.x > lo.x - 1e-9 && at.x < hi.x + 1e-9 && at.y > lo.y - 1e-9 && at.y < hi.y + 1e-9;
    }
    const Vec3 middle = lit.view().point(x.centroid);
    const bool within = middle.x > lo.x && middle.x < hi.x && middle.y > lo.y && middle.y < hi.y;
    if (within) (corners == int(x.vertex_count) ? under : across) += x.area;
  }
  EXPECT_NEAR(under, 1, 1e-9);
  EXPECT_EQ(across, 0);
}

TEST(Refine, SpotOfAPanelCloseToACeiling) {
  const Polygon ceiling = parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0});
  const Polygon panel = parallelogram({-.3, -.3, .02}, {0, .6, 0}, {.6, 0, 0});
  const Outcome o = carry_out({ceiling, panel, {}, 2}, settings_of(1e-3));
  EXPECT_NEAR(o.mean(), form_factor(ceiling, panel), 0.01 * form_factor(ceiling, panel));
  const auto exact = [&](const Vec3& x) { return point_to_polygon(x, {0, 0, 1}, panel); };
  EXPECT_LT(rms_error(o.tree, exact), allowed(o, 1e-3));
}

// Seen from the panel, the ceiling is what it is above the panel, not what it is in the mean: the
// spot, a hundredth of the ceiling, sends all that arrives.
TEST(Refine, ReceiverCloseToALargeSourceSeesThePartNextToIt) {
  Patches patches(2);
  const PatchId r = patches.add(parallelogram({-.2, -.2, .02}, {0, .4, 0}, {.4, 0, 0}));
  patches.add(parallelogram({-2, -2, 0}, {4, 0, 0}, {0, 4, 0}), {Spectrum{1}, Spectrum{0}});
  std::vector<PatchTree> trees = patches.trees();
  PatchTree& ceiling = trees[1];
  grow(ceiling, 511);
  GatherSlots light;
  light.reset(ceiling.elements.size(), ceiling.view().k());
  for (std::size_t i = 0; i < ceiling.elements.size(); ++i) {
    const Vec3 at = ceiling.view().point(ceiling.elements[i].centroid);
    if (ceiling.elements[i].leaf() && std::max(std::abs(at.x), std::abs(at.y)) < 0.25)
      for (int c = 0; c < kChannels; ++c)
        light.g[i * ceiling.view().k() * kGatherChannels + c] = 100;
  }
  push_pull(ceiling, light, {});
  std::vector<PatchTree> sources{ceiling};
  const Record record(0, sources);
  const ClusterView view = record.view();
  const SourceRoots roots(view);
  PatchTree receiver = trees[r.value];
  Refiner refiner(settings_of(0.01), {});
  LinkSet set;
  refiner.link(receiver, roots, set);
  refiner.flush();
  GatherSlots slots;
  slots.reset(receiver.elements.size(), receiver.view().k());
  RowMean mean;
  std::vector<SentDetail> details;
  const Braid braid = plait(ClusterId(0u), std::span(&set, 1));
  for (const Braid::Strand& strand : braid.strands)
    gather(braid, strand, {view, {}}, 2, receiver.elements, kNoCap, slots, mean, &details);
  push_pull(receiver, slots, {});
  const Polygon spot = parallelogram({-.25, -.25, 0}, {.5, 0, 0}, {0, .5, 0});
  const double exact =
      100 * form_factor(parallelogram({-.2, -.2, .02}, {0, .4, 0}, {.4, 0, 0}), spot);
  EXPECT_NEAR(receiver.e[0], exact, 0.01 * exact);
}

// What rays say of a crowd of blockers is in doubt, though all of them agree; what is measured past
// few hardly is, and an open transfer neither.
TEST(Refine, DoubtIsWhereACrowdStandsBetween) {
  const auto weight = [](const Outcome& o) {
    double sum = 0;
    const auto area = [&](const Ends& ends) { return o.tree.elements[ends.receiver].area; };
    for (const LinkHead& l : o.set.links) sum += l.doubt * area(l.ends);
    for (const ThinLink& l : o.set.thin) sum += l.doubt() * area(l.ends);
    for (const Doubt& d : o.set.doubts) sum += d.doubt * area(d.ends);
    return sum;
  };
  const auto past = [&](const std::vector<Polygon>& blockers) {
    return weight(carry_out({floor_square(), ceiling_square(1), blockers, 2}, settings_of(0.02)));
  };
  // Strips across the way that leave slits of a millimetre.
  const auto strips = [](int count) {
    std::vector<Polygon> out;
    const double step = 3.0 / count;
    for (int i = 0; i < count; ++i)
      out.push_back(parallelogram({-1 + i * step, -1, .5}, {step - .001, 0, 0}, {0, 3, 0}));
    return out;
  };
  EXPECT_LT(past({}), 1e-4);
  EXPECT_EQ(past({parallelogram({-1, -1, .5}, {3, 0, 0}, {0, 3, 0})}), 0);  // the tube knows
  EXPECT_GT(past(strips(30)), 10 * past({}));
  EXPECT_LT(past(strips(2)), 0.2 * past(strips(30)));
}

// Two squares a hundred metres apart: their transfer is too weak to matter in shape, and still
// there.
TEST(Refine, WeakTransfersAreThinAndNotLost) {
  const Polygon far = parallelogram({0, 0, 50}, {0, 1, 0}, {1, 0, 0});
  const Transfer t{floor_square(), far, {}, 2};
  const Outcome o = carry_out(t, settings_of(0.02));
  EXPECT_EQ(o.set.links.size(), 0u);
  EXPECT_EQ(o.set.thin.size(), 1u);
  EXPECT_NEAR(o.mean(), form_factor(t.receiver, far), 2e-3 * o.mean());
}

// A square a hundred times its size away brings 3e-5: less than a six-hundredth of the threshold.
TEST(Refine, NegligibleTransfersAreLeftToTheClosingOfTheirRow) {
  const Polygon far = parallelogram({0, 0, 100}, {0, 1, 0}, {1, 0, 0});
  EXPECT_TRUE(carry_out({floor_square(), far, {}, 2}, settings_of(0.02)).set.empty());
}

TEST(Refine, InertSourcesAndThoseTurnedAwayAreNotLinked) {
  Patches patches(2);
  patches.add(floor_square());
  patches.add(parallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}), {Spectrum{0}, Spectrum{1}});  // up
  patches.add(ceiling_square(2), {Spectrum{0}, Spectrum{1}});
  std::vector<PatchTree> trees = patches.trees();
  trees[2].head.inert = 1;
  const Record record(0, trees);
  const ClusterView view = record.view();
  const SourceRoots roots(view);
  PatchTree receiver = trees[0];
  Refiner refiner(settings_of(0.01), {});
  LinkSet set;
  refiner.link(receiver, roots, set);  // itself is in the cluster too
  refiner.flush();
  EXPECT_TRUE(set.empty());
}

// Two levels of links from a near and a far source, past a blocker, to one receiver.
struct TwoLevels {
  RefineSettings coarse = settings_of(0.1), fine = settings_of(0.04);
  double brighter = 1;  // the far source, at the second level

  // Whether the far source's pair, and the near one's, was taken over; all links at the second level.
  std::vector<bool> stays;
  LinkSet first, second;

  void carry_out() {
    const Polygon low = parallelogram({0.2, 0.2, 0.2}, {0, 0.5, 0}, {0.5, 0, 0});
    const Polygon far = parallelogram({-1, -1, 6}, {0, 3, 0}, {3, 0, 0});
    const Polygon aside = parallelogram({0.9, 0.9, 3}, {0.2, 0, 0}, {0, 0.2, 0});
    const std::vector<BlockerPolygon> blockers{
        {floor_square(), 0}, {low, 1}, {far, 2}, {aside, 3}};
    const BlockerIndex index(blockers);
    const RayScene rays(blockers);
    const Surroundings around{&index, &rays};
    PatchTree receiver;
    const auto sources = [&](double radiosity) {
      Patches patches(2);
      patches.add(floor_square());
      patches.add(low, {Spectrum{0}, Spectrum{1}});
      patches.add(far, {Spectrum{0}, Spectrum{radiosity}});
      std::vector<PatchTree> trees = patches.trees();
      if (receiver.elements.empty()) receiver = trees[0];
      return trees;
    };
    std::vector<PatchTree> dim = sources(1), bright = sources(brighter);
    const Record before(0, dim), now(0, bright);
    const ClusterView dim_view = before.view(), bright_view = now.view();
    const SourceRoots dim_roots(dim_view), bright_roots(bright_view);
    Refiner one(coarse, around), two(fine, around);
    one.link(receiver, dim_roots, first);
    one.flush();
    const Braid braid = plait(ClusterId(0u), std::span(&first, 1));
    stays = two.take_over(braid, *braid.strand_of(0), bright_roots, second);
    two.link(receiver, bright_roots, second, stays);
    two.flush();
  }
  static std::uint32_t source_patch_of(const LinkHead& l) { return l.ends.source_patch; }
  static std::size_t from(const LinkSet& set, std::uint32_t patch) {
    return std::ranges::count(set.links, patch, source_patch_of);
  }
};

constexpr std::uint32_t kNear = 1, kFar = 2;

TEST(RefineAgain, APairThatWasGoodEnoughKeepsItsLinkBitForBit) {
  TwoLevels levels;
  levels.carry_out();
  EXPECT_FALSE(levels.stays[kNear]);
  ASSERT_TRUE(levels.stays[kFar]);
  ASSERT_EQ(TwoLevels::from(levels.first, kFar), 1u);
  ASSERT_EQ(TwoLevels::from(levels.second, kFar), 1u);
  EXPECT_GT(TwoLevels::from(levels.second, kNear), TwoLevels::from(levels.first, kNear));
  const auto coupling = [](const LinkSet& set) {
    const std::size_t k2 = set.couplings.size() / set.links.size();
    const auto at_far = std::ranges::find(set.links, kFar, TwoLevels::source_patch_of);
    const auto i = at_far - set.links.begin();
    const auto at = set.couplings.begin() + i * std::ptrdiff_t(k2);
    return std::vector<float>(at, at + std::ptrdiff_t(k2));
  };
  EXPECT_EQ(coupling(levels.first), coupling(levels.second));
}

// What stays is what would be made.
TEST(RefineAgain, ItIsTheLinkThatWouldBeMadeAnew) {
  TwoLevels kept, anew;
  kept.carry_out();
  anew.coarse = anew.fine;  // its first level is the other's second
  anew.carry_out();
  EXPECT_EQ(TwoLevels::from(kept.second, kFar), TwoLevels::from(anew.first, kFar));
  EXPECT_EQ(kept.second.doubts.size(), anew.first.doubts.size());
}

TEST(RefineAgain, AMuchBrighterSourceIsLookedAtAgain) {
  TwoLevels levels;
  levels.brighter = 1000;
  levels.carry_out();
  EXPECT_FALSE(levels.stays[kFar]);
  EXPECT_GE(TwoLevels::from(levels.second, kFar), 1u);
}

TEST(RefineAgain, AMuchFinerThresholdTakesNothingOver) {
  TwoLevels levels;
  levels.fine = settings_of(1e-5);
  levels.carry_out();
  EXPECT_FALSE(levels.stays[kFar]);
}

TEST(Refine, MinEdgeBoundsTheElements) {
  RefineSettings s = settings_of(1e-5);
  s.min_edge = 0.2;
  const Outcome o = carry_out({floor_square(), wall_square(), {}, 2}, s);
  EXPECT_GT(o.tree.elements.size(), 1u);
  // A square is halved until the longer extent is below 0.4 m: 4 × 4 elements of 0.25 m.
  EXPECT_LE(o.tree.elements.size(), 31u);
}

}  // namespace
}  // namespace atrium::testing
