// Openings: what portals make together. A subdivision cuts a doorway into pieces wherever a plane
// runs on through it; a piece tells nothing of how wide the doorway is. Portals in one plane belong
// to one opening where they touch and the space on both sides of them is joined there.
//
// Invariants:
//  1. How wide an opening is at a place is the diameter of the largest ball that passes there.
//  2. A portal that such a ball of `size` passes, even in part, is wide; what lies within half of
//     `size` of where it passes belongs to the wide part: corners are no cracks.
//  3. Narrow openings are connected in their plane, and in the portals' order.
// Pure functions over a finished subdivision; safe from any thread.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "engine/scene.h"
#include "visibility/box_tree.h"
#include "visibility/bsp.h"
#include "visibility/portal.h"

namespace atrium {

struct NarrowOpening {
  std::vector<std::uint32_t> portals;  // that have a part of it
  std::vector<Polygon> outline;        // loops in its plane, holes too
  double width = 0;                    // m, where it is widest
  double length = 0;                   // m, its area over its width
  Vec3 widest{0};                      // the place where it is
  Vec3 along{0};                       // unit, its longest side's direction
};

struct Openings {
  std::vector<bool> wide;  // by portal
  std::vector<NarrowOpening> narrow;
};

// The portals between two cells, whichever is the front. They outlive it.
class Joints {
 public:
  explicit Joints(const std::vector<CellPortal>& portals);

  // Is one cell the other, or joined with it by a portal that holds the point?
  bool joined(std::uint32_t a, std::uint32_t b, const Vec3& x, double tolerance) const;

 private:
  const std::vector<CellPortal>& portals_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::uint32_t>> rows_;
};

// Do they touch in one plane where the space on both sides of them is joined?
bool one_opening(const CellPortal& p, const CellPortal& q, const Joints& joints, double tolerance);

// Portals by the opening that they are part of: rows that together hold each portal once.
Rows32 group_portals(const Bsp& bsp, const std::vector<CellPortal>& portals);

// Which portals a ball of `size` metres passes.
std::vector<bool> passable(const Bsp& bsp, const std::vector<CellPortal>& portals,
                           const Rows32& groups, double size);

// What a ball of `size` metres passes, and what it does not.
Openings find_openings(const Bsp& bsp, const std::vector<CellPortal>& portals, const Rows32& groups,
                       double size);

// Whose surfaces come near to the opening's rim: those that are near to most of it first. `tree` is
// of the scene's surfaces.
std::vector<ObjectId> objects_around(const Scene& scene, const BoxTree& tree,
                                     const NarrowOpening& opening);

}  // namespace atrium
