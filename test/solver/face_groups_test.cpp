// Groups of faces stand for their patches: what they hold is the mean of those, what they receive
// is what those receive, and what one face hides of another counts.
#include "solver/face_groups.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/squared.h"
#include "solver/form_factor.h"
#include "solver/gather.h"
#include "solver/refine.h"
#include "test/solver/settings.h"
#include "test/solver/trees.h"

namespace atrium::testing {
namespace {

constexpr double kTile = 0.1;  // m

// Square tiles in rows and columns that together face up at height z, from (x0, y0) on.
void add_tiles(Patches& patches, int rows, int columns, double z, bool up,
               const Paint& paint = {}) {
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Vec3 corner{kTile * i, kTile * j, z}, x{kTile, 0, 0}, y{0, kTile, 0};
      patches.add(up ? parallelogram(corner, x, y) : parallelogram(corner, y, x), paint);
    }
}

// An axis-parallel box's six faces.
void add_box(Patches& patches, const Vec3& lo, double side) {
  const Vec3 x{side, 0, 0}, y{0, side, 0}, z{0, 0, side};
  patches.add(parallelogram(lo, y, x));
  patches.add(parallelogram(lo + z, x, y));
  patches.add(parallelogram(lo, x, z));
  patches.add(parallelogram(lo + y, z, x));
  patches.add(parallelogram(lo, z, y));
  patches.add(parallelogram(lo + x, y, z));
}

class GroupRecord {
 public:
  GroupRecord(std::vector<PatchTree> trees, std::size_t least)
      : trees_(std::move(trees)), groups_(plant_groups(trees_, least)) {
    pull_groups(trees_, groups_);
    bytes_.resize(record_bytes(trees_, groups_));
    write_record(0, trees_, bytes_, groups_);
  }
  ClusterView view() const { return ClusterView::parse(bytes_).value(); }
  std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<PatchTree> trees_;
  GroupTree groups_;
  std::vector<std::byte> bytes_;
};

TEST(PlantGroups, BoxesFallApartIntoTheirSixSides) {
  Patches patches;
  for (int i = 0; i < 8; ++i) add_box(patches, {0.3 * i, 0.1 * (i % 3), 0}, 0.1);
  const std::vector<PatchTree> trees = patches.trees();
  const GroupTree tree = plant_groups(trees, 2);
  std::vector<int> seen(trees.size(), 0);
  int roots = 0;
  double area = 0;
  for (const FaceGroup& g : tree.groups) {
    EXPECT_NEAR(g.cone, 0, 1e-6);
    double sum = 0;
    for (const GroupMember& m : tree.view().members_of(g)) {
      const PatchHead& head = trees[m.patch].head;
      EXPECT_NEAR(dot(head.frame.n, g.axis), 1, 1e-12);
      EXPECT_LE(length(head.frame.to_space(trees[m.patch].elements[0].centroid) - g.center),
                g.radius);
      sum += head.area;
      seen[m.patch] += !g.inner;
    }
    EXPECT_NEAR(g.area, sum, 1e-12);
    roots += !g.inner;
    area += g.inner ? 0 : g.area;
  }
  EXPECT_EQ(roots, 6);
  EXPECT_NEAR(area, 8 * 6 * 0.01, 1e-12);
  EXPECT_EQ(std::ranges::count(seen, 1), std::ptrdiff_t(trees.size()));
}

TEST(PlantGroups, LampsLargePatchesAndSparseClustersHaveNone) {
  Patches patches;
  add_tiles(patches, 4, 5, 0, true);
  EXPECT_TRUE(plant_groups(patches.trees(), 21).groups.empty());
  EXPECT_FALSE(plant_groups(patches.trees(), 20).groups.empty());
  patches.add(parallelogram({0, 0, 1}, {1, 0, 0}, {0, 1, 0}));  // most of the cluster's area
  patches.add(parallelogram({0, 0, 2}, {.1, 0, 0}, {0, .1, 0}), {Spectrum{0}, Spectrum{1}});
  const GroupTree tree = plant_groups(patches.trees(), 2);
  EXPECT_EQ(tree.members.size(), 20u);
  for (const GroupMember& m : tree.members) EXPECT_LT(m.patch, 20u);
}

// Two patches, ρ .5 and 1 and E 2 and 4: B is 1 and 4, its mean over areas 3 : 1 is 1.75, and the
// root mean square about it √((3 · .75² + 2.25²) / 4).
TEST(PullGroups, MeanAndWhatItLeavesOut) {
  Patches patches;
  add_tiles(patches, 6, 6, 0, true);  // so that no patch is large
  const PatchId a =
      patches.add(parallelogram({5, 0, 0}, {.03, 0, 0}, {0, .1, 0}), {Spectrum{.5}, Spectrum{0}});
  const PatchId b =
      patches.add(parallelogram({5, 1, 0}, {.01, 0, 0}, {0, .1, 0}), {Spectrum{1}, Spectrum{0}});
  std::vector<PatchTree> trees = patches.trees();
  for (int c = 0; c < kChannels; ++c) {
    trees[a.value].e[c] = 2;
    trees[b.value].e[c] = 4;
  }
  GroupTree tree = plant_groups(trees, 2);
  pull_groups(trees, tree);
  const auto pair = std::ranges::find_if(tree.groups, [&](const FaceGroup& g) {
    const auto members = tree.view().members_of(g);
    return members.size() == 2 && std::ranges::all_of(members, [&](const GroupMember& m) {
             return m.patch == a.value || m.patch == b.value;
           });
  });
  ASSERT_NE(pair, tree.groups.end());
  EXPECT_NEAR(luminance(pair->radiosity), 1.75, 1e-12);
  EXPECT_NEAR(pair->detail, std::sqrt((3 * squared(.75) + squared(2.25)) / 4), 1e-12);
  EXPECT_NEAR(pair->irradiance, 2.5, 1e-12);
}

TEST(ClusterRecord, GroupsThatReachOutAreRefused) {
  Patches patches;
  add_tiles(patches, 5, 5, 0, true);
  GroupRecord record(patches.trees(), 2);
  const ClusterView whole = record.view();
  EXPECT_EQ(read_groups(whole).members.size(), 25u);
  const std::size_t at = std::size_t(
      reinterpret_cast<const std::byte*>(whole.groups().groups.data()) - record.bytes().data());
  auto& first = *reinterpret_cast<FaceGroup*>(record.bytes().data() + at);
  const FaceGroup sound = first;
  first.child[0] = 0;  // itself
  EXPECT_FALSE(ClusterView::parse(record.bytes()).ok());
  first = sound;
  first.child[1] = ~25;
  EXPECT_FALSE(ClusterView::parse(record.bytes()).ok());
  first = sound;
  first.member_count = 26;
  EXPECT_FALSE(ClusterView::parse(record.bytes()).ok());
  first = sound;
  EXPECT_TRUE(ClusterView::parse(record.bytes()).ok());
}

// All patches of one cluster receive from all of another, in which every B is 1, without groups or
// with: E is the form factor to what is seen.
struct Exchange {
  std::vector<PatchTree> trees;
  std::size_t links = 0;
  double mean() const {
    double sum = 0, area = 0;
    for (const PatchTree& t : trees) {
      sum += t.head.area * t.e[0];
      area += t.head.area;
    }
    return sum / area;
  }
};

constexpr std::size_t kNever = 1000000;

Exchange exchange(const Patches& receiver, const Patches& sender, std::size_t least,
                  double threshold, std::span<const Polygon> others = {}) {
  std::vector<PatchTree> from = sender.trees();
  std::vector<BlockerPolygon> blockers;
  for (std::size_t p = 0; p < from.size(); ++p)
    blockers.push_back({sender.polygon(PatchId(p)), std::uint32_t(blockers.size())});
  for (PatchTree& t : from) {
    t.head.patch += 100000;  // another cluster's
    t.head.reflectance = Spectrum{1};
    for (int c = 0; c < kChannels; ++c) t.e[c] = 1;
  }
  Exchange x{receiver.trees()};
  for (std::size_t p = 0; p < x.trees.size(); ++p)
    blockers.push_back({receiver.polygon(PatchId(p)), std::uint32_t(blockers.size())});
  for (const Polygon& p : others) blockers.push_back({p, std::uint32_t(blockers.size())});
  const GroupRecord record(std::move(from), least);
  const ClusterView view = record.view();
  const SourceRoots roots(view);
  GroupTree groups = plant_groups(x.trees, least);
  const BlockerIndex index(blockers);
  const RayScene rays(blockers);
  Refiner refiner(settings_of(threshold), {&index, &rays});
  std::vector<LinkSet> sets(x.trees.size() + groups.groups.size());
  std::vector<bool> grouped(x.trees.size(), false);
  for (const GroupMember& m : groups.members) grouped[m.patch] = true;
  for (std::size_t p = 0; p < x.trees.size(); ++p)
    if (!grouped[p]) refiner.link(x.trees[p], roots, sets[p]);
  const GroupReceiver receiving{x.trees, groups.view(), sets};
  for (std::size_t g = 0; g < groups.groups.size(); ++g)
    if (!groups.groups[g].inner) refiner.link(receiving, std::uint32_t(g), roots);
  refiner.flush();

  const Braid braid = plait(ClusterId(0u), sets);
  x.links = braid.count();
  std::vector<GatherSlots> slots(sets.size());
  std::vector<RowMean> means(sets.size());
  for (std::size_t i = 0; i < slots.size(); ++i)
    slots[i].reset(i < x.trees.size() ? x.trees[i].elements.size() : 1, x.trees[0].view().k());
  std::vector<SentDetail> details;
  for (const Braid::Strand& s : braid.strands) {
    Element whole;
    std::span<const Element> elements(&whole, 1);
    if (s.patch < x.trees.size())
      elements = x.trees[s.patch].elements;
    else
      whole.area = groups.groups[s.patch - x.trees.size()].area;
    gather(braid, s, {view, {}}, x.trees[0].order, elements, kNoCap, slots[s.patch], means[s.patch],
           &details);
  }
  push_groups(groups.view(), x.trees, slots, means);
  for (std::size_t p = 0; p < x.trees.size(); ++p) push_pull(x.trees[p], slots[p], {});
  return x;
}

double form_factor(PolygonView a, PolygonView b) { return polygon_to_polygon(a, b).value().f12; }

// Ten by ten tiles over ten by ten, a metre square over a metre square. What a link may be in error
// is the threshold over √area.
TEST(GroupLinks, TilesExchangeWhatTheirSquareDoesForFewerLinks) {
  for (const double height : {1.0, 4.0}) {
    Patches floor, ceiling;
    add_tiles(floor, 10, 10, 0, true);
    add_tiles(ceiling, 10, 10, height, false);
    const double exact = form_factor(parallelogram({0, 0, 0}, {1, 0, 0}, {0, 1, 0}),
                                     parallelogram({0, 0, height}, {0, 1, 0}, {1, 0, 0}));
    constexpr double kThreshold = 0.0005;
    const Exchange grouped = exchange(floor, ceiling, 2, kThreshold);
    const Exchange apart = exchange(floor, ceiling, kNever, kThreshold);
    EXPECT_NEAR(grouped.mean(), exact, 3 * kThreshold);
    EXPECT_LT(10 * grouped.links, apart.links) << height;
  }
}

// Every tile under a lamp close by has its own form factor, within ten times what one link may be
// wrong by on it.
TEST(GroupLinks, EveryTileReceivesItsOwn) {
  Patches floor, lamp;
  add_tiles(floor, 10, 10, 0, true);
  add_tiles(lamp, 4, 4, 0.3, false);
  constexpr double kThreshold = 0.0005;
  const Exchange x = exchange(floor, lamp, 2, kThreshold);
  const Polygon source = parallelogram({0, 0, 0.3}, {0, 0.4, 0}, {0.4, 0, 0});
  for (std::size_t p = 0; p < x.trees.size(); ++p)
    EXPECT_NEAR(x.trees[p].e[0], form_factor(floor.polygon(PatchId(p)), source),
                10 * kThreshold / kTile)
        << "tile " << p;
}

// Of two layers of tiles the lower one is hidden by the upper from all that is above: half of the
// group's area receives, and half sends.
TEST(GroupLinks, AGroupShadowsItself) {
  Patches layers, sky;
  add_tiles(layers, 8, 8, 0, true);
  add_tiles(layers, 8, 8, 0.01, true);
  add_tiles(sky, 8, 8, 1, false);
  const double exact = form_factor(parallelogram({0, 0, 0.01}, {.8, 0, 0}, {0, .8, 0}),
                                   parallelogram({0, 0, 1}, {0, .8, 0}, {.8, 0, 0}));
  constexpr double kThreshold = 0.0005;
  const Exchange down = exchange(layers, sky, 2, kThreshold);
  EXPECT_NEAR(down.mean(), exact / 2, 0.03 * exact);
  const Exchange up = exchange(sky, layers, 2, kThreshold);
  EXPECT_NEAR(up.mean(), exact, 0.05 * exact);
}

// A row of windows, their panes set back behind a wall's face, with a frame at either side whose
// profile has many faces one behind the other: the innermost one sees the pane of its own window,
// all along its edge, and hides it from the others.
struct Facade {
  static constexpr int kWindows = 8, kProfile = 8, kPieces = 5;
  static constexpr double kWide = 1, kHigh = 1.25, kDeep = 0.15, kBehind = 0.02, kApart = 1.5;  // m
  Patches panes, frames;
  double mean = 0;  // form factor of the frames to their panes
};

Facade facade() {
  Facade f;
  double sum = 0;
  const Vec3 wide{Facade::kWide, 0, 0}, high{0, Facade::kHigh, 0}, deep{0, 0, Facade::kDeep};
  const Vec3 piece = high / double(Facade::kPieces);
  for (int i = 0; i < Facade::kWindows; ++i) {
    const Vec3 o{Facade::kApart * i, 0, 0};
    const PatchId pane = f.panes.add(parallelogram(o, wide, high));
    for (int j = 0; j < Facade::kProfile; ++j)
      for (int k = 0; k < Facade::kPieces; ++k) {
        const Vec3 behind{Facade::kBehind * j, 0, 0}, at = o + double(k) * piece;
        const Polygon left = parallelogram(at - behind, piece, deep);
        const Polygon right = parallelogram(at + wide + behind, deep, piece);
        f.frames.add(left);
        f.frames.add(right);
        if (j > 0) continue;
        sum += form_factor(left, f.panes.polygon(pane));
        sum += form_factor(right, f.panes.polygon(pane));
      }
  }
  f.mean = sum / (2 * Facade::kWindows * Facade::kProfile * Facade::kPieces);
  return f;
}

// Of a group's four nodes none is of an innermost face in (7/8)⁴ = .59 of all draws: nothing is
// found then, and what is found otherwise does not make up for it. The thresholds are .4 and .8 of
// what an innermost face receives, a form factor of .42 to .0375 m²: √.0375 × .42 = .081.
TEST(GroupLinks, FramesReceiveWhatTheirOwnPanesSend) {
  const Facade f = facade();
  ASSERT_FALSE(plant_groups(f.frames.trees(), 2).groups.empty());
  for (const double threshold : {0.032, 0.064}) {
    const Exchange x = exchange(f.frames, f.panes, 2, threshold);
    EXPECT_NEAR(x.mean(), f.mean, 0.02 * f.mean) << threshold;
  }
}

// A wall between two groups leaves nothing, and no links.
TEST(GroupLinks, NothingThroughAWall) {
  Patches floor, ceiling;
  add_tiles(floor, 8, 8, 0, true);
  add_tiles(ceiling, 8, 8, 2, false);
  const std::vector<Polygon> wall{parallelogram({-9, -9, 1}, {20, 0, 0}, {0, 20, 0})};
  const Exchange x = exchange(floor, ceiling, 2, 0.002, wall);
  EXPECT_EQ(x.mean(), 0);
  EXPECT_EQ(x.links, 0u);
}

}  // namespace
}  // namespace atrium::testing
