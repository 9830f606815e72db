// The spatial subdivision: a binary space partition along the major opaque surfaces, its leaves
// the convex cells. [THFH94 §5; facts: visibility]
//
// Invariants:
//  1. A node's plane holds surfaces that cover a good share of its section of the node's space.
//  2. `opaque` is the union of all surfaces of the scene that lie in the plane (within tolerance)
//     there: what it leaves open of the section is where cells join.
//  3. Cells are numbered in the tree's order, front before back; the same scene gives the same
//     tree, turned, shifted or scaled too.
// Built once, then read from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry.h"
#include "engine/scene.h"
#include "visibility/plane_region.h"

namespace atrium {

// Strips, cracks and pieces narrower than this many tolerances are none.
inline constexpr double kSliverTolerances = 4;

// A node or, at the bottom, a cell.
struct BspRef {
  std::uint32_t value = 0;
  static constexpr std::uint32_t kCellBit = 1u << 31;
  static BspRef node(std::size_t i) { return {static_cast<std::uint32_t>(i)}; }
  static BspRef cell(std::size_t i) { return {static_cast<std::uint32_t>(i) | kCellBit}; }
  bool is_cell() const { return value & kCellBit; }
  std::uint32_t index() const { return value & ~kCellBit; }
};

struct CellFace {
  static constexpr std::uint32_t kOutside = ~0u;
  std::uint32_t node = kOutside;  // whose plane it lies in
  Plane plane;                    // facing the cell's inside
  Polygon polygon;
};

struct BspNode {
  Plane plane;
  BspRef front, back;
  Polygon section;  // of the node's space, counter-clockwise about the plane's normal
  PlaneRegion opaque;
  bool at_reveal = false;       // the split is along a reveal, or below such a one
  std::vector<CellFace> whole;  // the cell that it would be without, until it is pruned
};

struct ConvexCell {
  std::vector<CellFace> faces;
};

struct Bsp {
  std::vector<BspNode> nodes;
  std::vector<ConvexCell> cells;
  BspRef root;
  Frame frame;  // the scene's dominant directions: boxes are laid along them
  double tolerance = 0;
};

// m², of the surface below which half of all area is.
double median_of_area(const Scene& scene);

// Space that is no thicker than `gap` metres is split along whatever covers its section, small as
// that is: surfaces that miss each other's plane leave such space between their planes, and it
// would join the air over one solid to the inside of the next.
Bsp build_bsp(const Scene& scene, double gap = 0);

// Splits along reveals are tried wherever a hole leads on: into a wall's inside, or to a niche that
// ends there. Without those that leave little in the dark; `lit` says which cells are not.
struct CellJoint {
  std::uint32_t front = 0, back = 0;  // cells that a portal joins
};
// And without those that only divide one room's air into a crowd of cells. `rooms` says of the
// cells which belong together.
Bsp prune(const Bsp& bsp, std::span<const CellJoint> joints, const std::vector<bool>& lit,
          std::span<const std::uint32_t> rooms);

// A plane's cut through the cell that the faces bound: the square about `middle` with the half
// sides u and v in the plane, as large as the cell at least, clipped by the faces. May be empty.
Polygon section(const std::vector<CellFace>& faces, const Vec3& middle, const Vec3& u,
                const Vec3& v, double tolerance);

// What of a polygon one cell has.
struct CellPiece {
  std::uint32_t cell = 0;
  Polygon polygon;
};

// Drops a polygon down the tree: the pieces of it in each cell, as a point just off the polygon
// towards `side` would find them. No piece is a sliver: what would be stays with its neighbour.
void drop_polygon(const Bsp& bsp, BspRef from, PolygonView polygon, const Vec3& side,
                  std::vector<CellPiece>& out);

// Which side of the plane a polygon goes to when it hangs off its own plane towards `side`.
enum class DropSide { kFront, kBack, kBoth };
DropSide drop_side(const Plane& plane, PolygonView polygon, const Vec3& side, double tolerance);

// The two parts of a polygon that goes to both; one is empty where it would be a sliver, the other
// then is the whole polygon.
Split split_off_slivers(PolygonView polygon, const Plane& plane, double tolerance);

}  // namespace atrium
