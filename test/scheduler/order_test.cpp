// Gather orders on models made by hand: which clusters may see which is all that most of them ask.
#include "scheduler/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <random>

#include "pagestore/lower_bound.h"
#include "pagestore/simulate.h"
#include "scheduler/orders/cells.h"
#include "scheduler/orders/gather_sets.h"

namespace atrium {
namespace {

// A cluster of one square, the side given, about a point.
void add_cluster(Model& model, const Vec3& center, double side = 1) {
  Cluster cluster;
  cluster.first_patch = std::uint32_t(model.patches.size());
  cluster.patch_count = 1;
  Patch patch;
  patch.material = MaterialId(0u);
  patch.cluster = ClusterId(model.clusters.size());
  patch.first_vertex = std::uint32_t(model.vertices.size());
  patch.vertex_count = 4;
  const double h = side / 2;
  for (const Vec3& corner : {Vec3{-h, -h, 0}, Vec3{h, -h, 0}, Vec3{h, h, 0}, Vec3{-h, h, 0}}) {
    model.vertices.push_back(center + corner);
    cluster.bounds.extend(model.vertices.back());
  }
  model.patches.push_back(patch);
  model.clusters.push_back(cluster);
}

using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

// Who may see whom, both ways; the clusters are there already.
void see(Model& model, const Pairs& pairs) {
  std::vector<std::vector<ClusterId>> rows(model.clusters.size());
  for (const auto& [a, b] : pairs) {
    rows[a].push_back(ClusterId(b));
    if (a != b) rows[b].push_back(ClusterId(a));
  }
  model.visible = {};
  for (auto& row : rows) {
    std::sort(row.begin(), row.end());
    model.visible.push_row(row);
  }
}

Model in_a_row(std::size_t clusters, const Pairs& pairs) {
  Model model;
  for (std::size_t c = 0; c < clusters; ++c) add_cluster(model, {double(c), 0, 0});
  see(model, pairs);
  model.cells_of_cluster = {};
  for (std::size_t c = 0; c < clusters; ++c) model.cells_of_cluster.push_row({});
  return model;
}

Model random_model(std::mt19937& random, std::size_t clusters) {
  Pairs pairs;
  for (std::uint32_t a = 0; a < clusters; ++a)
    for (std::uint32_t b = a; b < clusters; ++b)
      if (random() % 3 == 0) pairs.push_back({a, b});
  return in_a_row(clusters, pairs);
}

const std::vector<Material>& plain_paint() {
  static const std::vector<Material> materials{{"paint", Spectrum{0.5}, Spectrum{0}}};
  return materials;
}

std::vector<std::uint32_t> ordered(const std::string& name, const Model& model,
                                   std::span<const Material> materials = plain_paint(),
                                   std::uint64_t seed = 1) {
  const Result<std::vector<ClusterId>> order = make_order(name, {model, materials, seed});
  EXPECT_TRUE(order.ok()) << order.status().message();
  std::vector<std::uint32_t> numbers;
  for (const ClusterId c : *order) numbers.push_back(c.value);
  return numbers;
}

using Numbers = std::vector<std::uint32_t>;

// Rooms whose clusters all see each other, and of which two see into the next room.
Model rooms_in_a_row(std::uint32_t rooms, std::uint32_t in_each) {
  Pairs pairs;
  for (std::uint32_t r = 0; r < rooms; ++r)
    for (std::uint32_t a = r * in_each; a < (r + 1) * in_each; ++a) {
      for (std::uint32_t b = a; b < (r + 1) * in_each; ++b) pairs.push_back({a, b});
      if (r + 1 < rooms && a % in_each < 2)
        for (std::uint32_t b = 0; b < 2; ++b) pairs.push_back({a, (r + 1) * in_each + b});
    }
  return in_a_row(std::size_t(rooms) * in_each, pairs);
}

TEST(Order, UnknownNameIsRefusedWithThoseThereAre) {
  const Status status = check_order("zigzag");
  EXPECT_EQ(status.code(), Code::kUsage);
  for (const std::string& name : order_names())
    EXPECT_NE(status.remedy().find(name), std::string::npos) << name;
}

TEST(Order, EachIsAPermutationAndTheSameTwice) {
  std::mt19937 random(1);
  for (const std::size_t clusters : {0, 1, 2, 40}) {
    const Model model = random_model(random, clusters);
    for (const std::string& name : order_names()) {
      const Numbers order = ordered(name, model);
      Numbers sorted = order, all(clusters);
      std::sort(sorted.begin(), sorted.end());
      std::iota(all.begin(), all.end(), 0u);
      EXPECT_EQ(sorted, all) << name;
      EXPECT_EQ(ordered(name, model), order) << name;
    }
  }
}

TEST(Order, RandomGoesByItsSeed) {
  const Model model = in_a_row(40, {});
  EXPECT_EQ(ordered("random", model, plain_paint(), 1), ordered("random", model, plain_paint(), 1));
  EXPECT_NE(ordered("random", model, plain_paint(), 1), ordered("random", model, plain_paint(), 2));
}

// The walk goes from cell 0 through the wider door to 2, from there back to the one it left out.
// Gathered to when the walk leaves a cell, 2 comes first.
TEST(Order, CellsGoThroughTheWidestDoor) {
  Model model = in_a_row(3, {});
  model.cells.resize(3);
  for (Cell& cell : model.cells) cell.lit = true;
  model.portals = {{CellId(0u), CellId(1u), 0, 0, 1}, {CellId(0u), CellId(2u), 0, 0, 2}};
  model.cells_of_cluster = {};
  for (std::uint32_t c = 0; c < 3; ++c) {
    const CellId cell(c);
    model.cells_of_cluster.push_row({&cell, 1});
  }
  EXPECT_EQ(ordered("cell", model), (Numbers{0, 2, 1}));
  const CellWalk walk = walk_cells(model);
  EXPECT_EQ(walk.left, (std::vector<CellId>{CellId(2u), CellId(1u), CellId(0u)}));
}

// All in one cell. 0 and 2 see 3 and 4, 1 sees 5 alone: from 0 the nearest is 2, which reads the
// same but for itself.
TEST(Order, WithinACellTheNearestIsNext) {
  Model model = in_a_row(6, {{0, 3}, {0, 4}, {2, 3}, {2, 4}, {1, 5}});
  model.cells.resize(1);
  model.cells[0].lit = true;
  model.cells_of_cluster = {};
  const CellId cell(0u);
  for (int c = 0; c < 6; ++c) model.cells_of_cluster.push_row({&cell, 1});
  const Numbers order = ordered("cell", model);
  EXPECT_EQ(order[0], 0u);
  EXPECT_EQ(order[1], 2u);
}

// 0 sees 1, 2 and 3. Sets: 0 {0123}, 1 {01}, 2 {0123} as it sees 1 and 3 too, so 2 differs by
// nothing; of 1 {012} and 3 {023} either differs from 2's by one record, and 1 is the first.
// The definition, step by step, all clusters looked at. [THFH94 §6]
Numbers source_order_by_hand(const Model& model) {
  const std::size_t n = model.clusters.size();
  std::vector<std::uint32_t> acted(n, 0);
  Numbers order;
  for (std::uint32_t last = 0; order.size() < n;) {
    const auto distance2 = [&](std::uint32_t c) {
      const Vec3 d = model.clusters[c].bounds.center() - model.clusters[last].bounds.center();
      return dot(d, d);
    };
    std::uint32_t best = std::uint32_t(n);
    for (std::uint32_t c = 0; c < n; ++c) {
      if (std::ranges::count(order, c) > 0) continue;
      if (best == n || acted[c] > acted[best] ||
          (acted[c] == acted[best] && distance2(c) < distance2(best)))
        best = c;
    }
    order.push_back(last = best);
    for (const ClusterId s : model.visible[last]) ++acted[s.value];
  }
  return order;
}

// 0 sees 3 and 4: both have acted once, and 3 is nearer. It sees 1, and 4 once more: that is next.
// From there 1 and 2 are left, which has not acted.
TEST(Order, SourceTakesWhatHasActedMostAndTheNearestOfThose) {
  EXPECT_EQ(ordered("source", in_a_row(5, {{0, 3}, {0, 4}, {3, 1}, {3, 4}})),
            (Numbers{0, 3, 4, 1, 2}));
}

// Places on a lattice, so that many are as near as others; few see each other, or many, or none.
TEST(Order, SourceIsItsDefinitionOnAnyModel) {
  std::mt19937 random(6);
  for (const std::uint32_t one_in : {2u, 10u, 50u, 10000u}) {
    Model model;
    for (int c = 0; c < 120; ++c)
      add_cluster(model, {double(random() % 6), double(random() % 5), double(random() % 4)});
    Pairs pairs;
    for (std::uint32_t a = 0; a < 120; ++a)
      for (std::uint32_t b = a; b < 120; ++b)
        if (random() % one_in == 0) pairs.push_back({a, b});
    see(model, pairs);
    EXPECT_EQ(ordered("source", model), source_order_by_hand(model)) << one_in;
  }
}

TEST(Order, NearestReadsMostNearlyTheSame) {
  const Model model = in_a_row(4, {{0, 1}, {0, 2}, {0, 3}, {2, 1}, {2, 3}});
  EXPECT_EQ(ordered("nearest", model), (Numbers{0, 2, 1, 3}));
}

// A chain 0 - 3 - 1 - 4 - 2: nearest goes down it to its end; then, as 5 is seen by none, on to it.
TEST(Order, NearestFollowsAChain) {
  const Model model = in_a_row(6, {{0, 3}, {3, 1}, {1, 4}, {4, 2}});
  EXPECT_EQ(ordered("nearest", model), (Numbers{0, 3, 1, 4, 2, 5}));
}

// A star whose middle 0 sees the chain 1 - 2 - 3, and 4: each pair that sees each other is an edge
// of the tree. The branch of one is taken before the branch of three.
TEST(Order, TreeTakesSmallBranchesFirst) {
  const Model model = in_a_row(5, {{0, 1}, {1, 2}, {2, 3}, {0, 4}});
  EXPECT_EQ(ordered("tree", model), (Numbers{0, 4, 1, 2, 3}));
}

// What Hilbert's curve is for: through a grid each step goes to a neighbour.
TEST(Order, HilbertStepsToNeighbors) {
  Model model;
  for (int x = 0; x < 4; ++x)
    for (int y = 0; y < 4; ++y)
      for (int z = 0; z < 4; ++z) add_cluster(model, {double(x), double(y), double(z)});
  see(model, {});
  const Numbers order = ordered("hilbert", model);
  for (std::size_t i = 1; i < order.size(); ++i)
    EXPECT_NEAR(length(model.clusters[order[i]].bounds.center() -
                       model.clusters[order[i - 1]].bounds.center()),
                1, 1e-9);
}

// A lamp at 0 and walls of equal paint at 1, 2 and 3 m, of which the last does not see it: nearer
// is brighter.
TEST(Order, BrightGoesByTheLightThatArrives) {
  Model model;
  for (const double at : {0, 2, 1, 3}) add_cluster(model, {0, 0, at});
  model.patches[0].material = MaterialId(1u);
  see(model, {{0, 1}, {0, 2}, {1, 3}, {2, 3}});
  const std::vector<Material> materials{{"paint", Spectrum{0.5}, Spectrum{0}},
                                        {"lamp", Spectrum{0}, Spectrum{100}}};
  const Numbers order = ordered("bright", model, materials);
  EXPECT_EQ(order[0], 2u);
  EXPECT_EQ(order[1], 1u);
}

// Six gathers, reach 2. 0 and 1 see each other, the others nobody. In model order records 0 and 1
// have gaps 1 and 5, of which the arena keeps the first by half: 2 (1/2 + 1); each of the others is
// read once an iteration.
TEST(LikelyBytes, GapsBeyondReachAreReads) {
  const Model model = in_a_row(6, {{0, 1}});
  const GatherSets gathers = find_gather_sets(model);
  const double one = gathers.bytes[0];
  std::vector<ClusterId> order;
  for (std::uint32_t c = 0; c < 6; ++c) order.push_back(ClusterId(c));
  ASSERT_EQ(arena_reach(6), 2u);
  EXPECT_NEAR(likely_bytes(gathers, order), one * (2 * 1.5 + 4), 1e-9 * one);
}

TEST(Tour, NeverWorseThanWhatItStartsFrom) {
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const Model model = random_model(random, 5 + random() % 60);
    const GatherSets gathers = find_gather_sets(model);
    const auto likely = [&](const std::string& name) {
      return likely_bytes(gathers, *make_order(name, {model, plain_paint(), 1}));
    };
    const double tour = likely("tour");
    for (const std::string name : {"cell", "nearest", "tree", "hilbert"})
      EXPECT_LE(tour, likely(name) * (1 + 1e-12)) << name << ", model " << i;
  }
}

// Ten rooms, their clusters numbered all over the place, and no cells or places to go by: the tour
// reads less than half of what model order does, and no more than going from room to room.
TEST(Tour, FindsTheRooms) {
  constexpr std::uint32_t kRooms = 10, kInEach = 12;
  const Model tidy = rooms_in_a_row(kRooms, kInEach);
  Numbers number(tidy.clusters.size());
  std::iota(number.begin(), number.end(), 0u);
  std::mt19937 random(3);
  for (std::size_t i = number.size(); i > 1; --i) std::swap(number[i - 1], number[random() % i]);
  Pairs pairs;
  for (std::uint32_t c = 0; c < number.size(); ++c)
    for (const ClusterId s : tidy.visible[c])
      if (s.value >= c) pairs.push_back({number[c], number[s.value]});
  const Model model = in_a_row(number.size(), pairs);
  const GatherSets gathers = find_gather_sets(model);
  std::vector<ClusterId> room_by_room;
  for (const std::uint32_t n : number) room_by_room.push_back(ClusterId(n));
  const double tour = likely_bytes(gathers, *make_order("tour", {model, plain_paint(), 1}));
  EXPECT_LT(tour, likely_bytes(gathers, *make_order("model", {model, plain_paint(), 1})) / 2);
  EXPECT_LE(tour, likely_bytes(gathers, room_by_room) * 1.02);
}

// Sampled: what two sets differ by, from a share of the records, is right on average. Here nothing
// is sampled, and it is exact: 0 sees 1 and 2, 3 sees 1; {0 1 2} and {1 3} differ by 0, 2 and 3.
TEST(GatherSets, DistanceIsWhatOneHoldsAndTheOtherDoesNot) {
  const Model model = in_a_row(4, {{0, 1}, {0, 2}, {1, 3}});
  const GatherSets gathers = find_gather_sets(model);
  EXPECT_EQ(gathers.share, 1);
  const std::vector<double>& bytes = gathers.bytes;
  EXPECT_NEAR(distance(gathers, 0, 3), bytes[0] + bytes[2] + bytes[3], 1e-6);
}

// Two iterations in an order, as a solve's trace has them; sizes are given by record.
Trace trace_of(const Model& model, std::span<const std::uint32_t> order,
               const std::vector<std::uint64_t>& sizes) {
  Trace trace;
  trace.pins = true;
  for (std::uint32_t c = 0; c < sizes.size(); ++c) trace.ids.push_back(c);
  trace.sizes = sizes;
  for (std::uint64_t iteration = 1; iteration <= 2; ++iteration) {
    trace.events.push_back({TraceOp::kIteration, 0, iteration});
    for (const std::uint32_t receiver : order) {
      trace.events.push_back({TraceOp::kGather, receiver, sizes[receiver]});
      trace.events.push_back({TraceOp::kRead, receiver, sizes[receiver]});
      for (const ClusterId s : model.visible[receiver]) {
        if (s.value == receiver) continue;
        trace.events.push_back({TraceOp::kRead, s.value, sizes[s.value]});
        trace.events.push_back({TraceOp::kRelease, s.value, sizes[s.value]});
      }
      trace.events.push_back({TraceOp::kRelease, receiver, sizes[receiver]});
    }
  }
  trace.events.push_back({TraceOp::kIteration, 0, kBetweenIterations});
  return trace;
}

// All 720 orders of six clusters, with the two policies that know all that comes: none reads less
// than the bounds say. The bound of any order is one number for all of them.
TEST(LowerBound, NoOrderReadsLess) {
  std::mt19937 random(4);
  double closest = 1e9;
  int says_something = 0;
  for (int i = 0; i < 6; ++i) {
    const Model model = random_model(random, 6);
    std::vector<std::uint64_t> sizes;
    for (int c = 0; c < 6; ++c) sizes.push_back(1000 + random() % 20000);
    Numbers order(6);
    std::iota(order.begin(), order.end(), 0u);
    const std::uint64_t smallest =
        smallest_feasible_arena(trace_of(model, order, sizes), false);
    const std::uint64_t arena = smallest + random() % 20000;
    const std::uint64_t any = least_bytes(trace_of(model, order, sizes), arena, 2).in_any_order;
    says_something += any > 0;
    do {
      const Trace trace = trace_of(model, order, sizes);
      const LeastBytes least = least_bytes(trace, arena, 2);
      ASSERT_EQ(least.in_any_order, any);
      for (const char* policy : {"belady", "belady-size"}) {
        const Simulation s = *simulate(trace, policy, arena, false, {}, 2);
        ASSERT_GE(double(s.miss_bytes) * (1 + 1e-6) + 1e-6, least.in_this_order) << policy;
        ASSERT_GE(s.miss_bytes, any) << policy;
        if (least.in_this_order > 0)
          closest = std::min(closest, double(s.miss_bytes) / least.in_this_order);
      }
    } while (std::next_permutation(order.begin(), order.end()));
  }
  EXPECT_LT(closest, 1.1);
  EXPECT_GT(says_something, 0);
}

}  // namespace
}  // namespace atrium
