#include "visibility/portal_flow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "test/visibility/scene_builder.h"

namespace atrium {
namespace {

struct Flowing {
  Bsp bsp;
  PortalGraph graph;
};

// A fourth room behind, its doorway at y < 1 again: no line through the first two reaches it.
Flowing four_rooms() {
  SceneBuilder s = rooms_in_a_row();
  s.quad("wall 3", {10, 1, 0}, {0, 3, 0}, {0, 0, 3}, kBothSides);
  Flowing f{build_bsp(s.build()), {}};
  f.graph = make_graph(f.bsp, find_portals(f.bsp));
  return f;
}

std::set<std::uint32_t> cells_seen(const PortalFlow& flow) {
  std::set<std::uint32_t> cells;
  flow.each_seen([&](const SeenSpace& space) { cells.insert(space.cell); });
  return cells;
}

TEST(PortalFlow, OutOfStepsItSeesMoreAndNeverLess) {
  const Flowing f = four_rooms();
  PortalFlow flow(f.graph);
  std::size_t more = 0;
  for (std::uint32_t p = 0; p < f.graph.portals.size(); ++p) {
    flow.run(f.graph.portals[p].polygon, f.graph.portals[p].to, 1'000'000);
    const std::set<std::uint32_t> narrow = cells_seen(flow);
    flow.run(f.graph.portals[p].polygon, f.graph.portals[p].to, 0);
    const std::set<std::uint32_t> flooded = cells_seen(flow);
    EXPECT_TRUE(std::includes(flooded.begin(), flooded.end(), narrow.begin(), narrow.end()));
    more += flooded.size() - narrow.size();
  }
  EXPECT_GT(more, 0u);
}

TEST(PortalFlow, CellsSeeEachOtherFromBothSides) {
  const Flowing f = four_rooms();
  PortalFlow flow(f.graph);
  std::vector<std::set<std::uint32_t>> seen(f.bsp.cells.size());
  for (std::uint32_t p = 0; p < f.graph.portals.size(); ++p) {
    flow.run(f.graph.portals[p].polygon, f.graph.portals[p].to, 1'000'000);
    std::set<std::uint32_t>& row = seen[f.graph.portals[p].from];
    row.merge(cells_seen(flow));
    row.insert(f.graph.portals[p].to);
  }
  for (std::uint32_t a = 0; a < seen.size(); ++a)
    for (std::uint32_t b : seen[a]) EXPECT_TRUE(a == b || seen[b].contains(a)) << a << " " << b;
}

TEST(PortalFlow, AFlatBoxHasFourCornersAndAFullOneEight) {
  const Frame frame;
  Box box;
  box.extend({0, 0, 0});
  box.extend({1, 2, 0});
  EXPECT_EQ(corners_of(frame, box, 1e-9).size(), 4u);
  box.extend({1, 2, 3});
  EXPECT_EQ(corners_of(frame, box, 1e-9).size(), 8u);
}

}  // namespace
}  // namespace atrium
