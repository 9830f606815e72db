// Regions of a plane on an integer grid: what is opaque in a splitting plane, and what of a
// footprint it leaves open.
//
// Invariants:
//  1. Grid coordinates are whole multiples of `unit`, a tenth of the scene's tolerance: the same
//     polygons give the same region whatever their order.
//  2. Outer loops run counter-clockwise, holes clockwise; no loop crosses another.
//  3. Everything errs towards open: cracks below the given gap are closed, nothing else is.
// Pure functions over plain data; safe from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

struct GridPoint {
  std::int64_t x = 0, y = 0;
  friend bool operator==(const GridPoint&, const GridPoint&) = default;
};

struct PlaneGrid {
  Frame frame;
  double unit = 1;  // m, of one grid step

  GridPoint to_grid(const Vec3& x) const;
  Vec3 to_space(const GridPoint& p) const;
};

struct PlaneRegion {
  PlaneGrid grid;
  std::vector<std::vector<GridPoint>> loops;
  bool empty() const { return loops.empty(); }
};

// The union of convex polygons that lie in the grid's plane, cracks narrower than `gap` metres
// between them closed.
PlaneRegion union_of(const PlaneGrid& grid, std::span<const Polygon> polygons, double gap);

struct OpenPiece {
  Polygon polygon;  // convex, counter-clockwise about the grid's normal
  double area = 0;  // m² of it that are open; the rest was filled to make it convex
};

// The convex footprint minus the opaque region, in convex pieces that together cover all of it but
// strips narrower than `sliver` metres.
std::vector<OpenPiece> open_pieces(const PlaneRegion& opaque, PolygonView footprint, double sliver);

// Does the region hold the point of its plane?
bool contains(const PlaneRegion& region, const Vec3& x);

// How many metres of the segment lie in the region.
double covered_length(const PlaneRegion& region, const Vec3& a, const Vec3& b);

// About how wide a polygon is where it is thin: twice its area over its perimeter, m.
double strip_width(PolygonView polygon);

}  // namespace atrium
