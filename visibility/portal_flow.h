// Portal flow: what can be seen from a convex source through sequences of portals. [Teller 92]
// Sight spreads outward from the source, nearest portal first; each portal keeps one convex window
// of what is seen of it, which grows as more sequences arrive; planes that separate the source from
// a window bound what is seen beyond it.
//
// Invariants:
//  1. Conservative: what a straight line from the source reaches through open portals lies within
//     the reported planes of some reached window. Windows only err by being too large.
//  2. A portal is expanded at most kMostVisits times, the last time as a whole, so the work is
//     bounded by the graph; past `most_steps` sight is no longer narrowed, only flooded.
//  3. The result depends on the graph and the source alone.
// A graph is immutable; a flow is scratch for one thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "visibility/bsp.h"
#include "visibility/portal.h"

namespace atrium {

// The corners of a box in coordinates of the frame; flat where its extent is below `tolerance`.
std::vector<Vec3> corners_of(const Frame& frame, const Box& box, double tolerance);

// A portal passed in one direction.
struct DirectedPortal {
  Polygon polygon;  // counter-clockwise about the plane's normal
  Plane plane;      // its normal along the passage
  std::uint32_t from = 0, to = 0;
  std::uint32_t twin = 0;  // the same portal passed the other way
};

// Those that leave one cell follow each other, in the cells' order.
struct PortalGraph {
  std::vector<DirectedPortal> portals;
  std::vector<std::uint32_t> first_out;  // by cell, and one more: its first portal
  std::vector<double> x, y, z, radius;   // of the balls around the portals, m
  double tolerance = 0;
  std::size_t cells() const { return first_out.size() - 1; }
};
PortalGraph make_graph(const Bsp& bsp, const std::vector<CellPortal>& portals);

// Part of a cell that is seen: what lies on or before all of the planes.
struct SeenSpace {
  std::uint32_t cell = 0;
  std::span<const Plane> planes;
};

class PortalFlow {
 public:
  explicit PortalFlow(const PortalGraph& graph);

  // From all points of a convex source in a cell, given by its corners. Afterwards each_seen
  // reports what was reached, the source's own cell left out.
  void run(std::span<const Vec3> source, std::uint32_t cell, std::size_t most_steps);

  // From a convex source in a cell within limits, planes before which all lines of interest lie,
  // until `found` says of some of what is seen that it will do. Did it? Past `most_steps` it did.
  template <class Found>
  bool run_within(std::span<const Vec3> source, std::uint32_t cell, std::span<const Plane> limits,
                  std::size_t most_steps, Found&& found) {
    start(source, most_steps);
    limits_ = limits;
    spread(cell, kNone);
    bool done = false;
    while (!done && !queue_.empty()) {
      const std::uint32_t portal = expand_next();
      done = flooded_ || found(SeenSpace{graph_.portals[portal].to, windows_[portal].planes});
    }
    return done;
  }

  template <class Visit>
  void each_seen(Visit&& visit) const {
    for (std::uint32_t portal : reached_)
      visit(SeenSpace{graph_.portals[portal].to, windows_[portal].planes});
  }
  std::size_t steps() const { return steps_; }  // windows looked at by the last run

 private:
  static constexpr std::uint32_t kNone = ~0u;
  static constexpr std::uint8_t kMostVisits = 3;

  struct Window {
    std::uint32_t run = 0;  // of which this window is
    std::uint8_t visits = 0;
    bool queued = false;
    bool whole = false;  // it is the whole portal
    Polygon polygon;
    std::vector<Plane> planes;  // that bound what is seen through it, as last expanded
  };
  struct Waiting {
    double distance;
    std::uint32_t portal;
  };

  static bool later(const Waiting& a, const Waiting& b);
  void start(std::span<const Vec3> source, std::size_t most_steps);
  void spread(std::uint32_t cell, std::uint32_t entered);
  std::uint32_t expand_next();
  void find_reaching(std::uint32_t cell);
  bool see(std::uint32_t portal);
  void reach(std::uint32_t portal);
  void bounding_planes(std::uint32_t portal);
  bool behind(const Plane& plane) const;

  const PortalGraph& graph_;
  std::vector<Vec3> source_;
  Vec3 center_{0};
  std::uint32_t run_ = 0;
  std::size_t steps_ = 0, most_steps_ = 0;
  bool flooded_ = false;
  std::vector<Window> windows_;
  std::vector<std::uint32_t> reached_;
  std::vector<Waiting> queue_;
  std::vector<Plane> planes_;
  std::span<const Plane> limits_;
  std::vector<const Plane*> cutting_;
  std::vector<double> reach_;  // of the portals out of a cell: how far their balls reach in
  Polygon seen_, scratch_;
};

}  // namespace atrium
