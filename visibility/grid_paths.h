// Paths on a plane's grid: what regions of a plane and openings in it are computed with. Clipper
// behind it, of which nothing shows here.
//
// Outer loops run counter-clockwise, holes clockwise, so that areas add up.
// Pure functions; safe from any thread.
#pragma once

#include <vector>

#include "visibility/plane_region.h"

namespace atrium {

using GridPath = std::vector<GridPoint>;
using GridPaths = std::vector<GridPath>;

enum class Combine { kUnion, kIntersection, kDifference };

// Counter-clockwise, whatever the polygon is.
GridPath to_path(const PlaneGrid& grid, PolygonView polygon);
void make_counter_clockwise(GridPath& path);
Polygon to_polygon(const PlaneGrid& grid, const GridPath& path);

// Grown by so many grid steps, or shrunk where they are negative; corners stay corners.
GridPaths offset(const GridPaths& paths, double steps);

// Outer loops with their holes.
std::vector<GridPaths> combine(const GridPaths& subject, const GridPaths& clip, Combine how);

// Grid steps squared.
double area_of(const GridPath& path);
double area_of(const GridPaths& paths);

}  // namespace atrium
