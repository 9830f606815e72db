#include "visibility/grid_paths.h"

#include <algorithm>
#include <polyclipping/clipper.hpp>

namespace atrium {

namespace {

using ClipperLib::Path;
using ClipperLib::Paths;
using ClipperLib::PolyNode;

// How far beyond its corner an offset corner may reach, in offsets.
constexpr double kMiterLimit = 4;

Paths to_clipper(const GridPaths& paths) {
  Paths out(paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i)
    for (const GridPoint& p : paths[i]) out[i].emplace_back(p.x, p.y);
  return out;
}

GridPath from_clipper(const Path& path) {
  GridPath out;
  out.reserve(path.size());
  for (const auto& p : path) out.push_back({p.X, p.Y});
  return out;
}

void parts_below(const PolyNode& outside, std::vector<GridPaths>& out) {
  for (const PolyNode* outer : outside.Childs) {
    GridPaths part{from_clipper(outer->Contour)};
    for (const PolyNode* hole : outer->Childs) {
      part.push_back(from_clipper(hole->Contour));
      parts_below(*hole, out);
    }
    out.push_back(std::move(part));
  }
}

ClipperLib::ClipType clip_type(Combine how) {
  switch (how) {
    case Combine::kUnion:
      return ClipperLib::ctUnion;
    case Combine::kIntersection:
      return ClipperLib::ctIntersection;
    case Combine::kDifference:
      break;
  }
  return ClipperLib::ctDifference;
}

}  // namespace

GridPath to_path(const PlaneGrid& grid, PolygonView polygon) {
  GridPath path;
  path.reserve(polygon.size());
  for (const Vec3& x : polygon) path.push_back(grid.to_grid(x));
  make_counter_clockwise(path);
  return path;
}

void make_counter_clockwise(GridPath& path) {
  if (area_of(path) < 0) std::reverse(path.begin(), path.end());
}

Polygon to_polygon(const PlaneGrid& grid, const GridPath& path) {
  Polygon polygon;
  polygon.reserve(path.size());
  for (const GridPoint& p : path) polygon.push_back(grid.to_space(p));
  return polygon;
}

GridPaths offset(const GridPaths& paths, double steps) {
  ClipperLib::ClipperOffset clipper(kMiterLimit);
  clipper.AddPaths(to_clipper(paths), ClipperLib::jtMiter, ClipperLib::etClosedPolygon);
  Paths grown;
  clipper.Execute(grown, steps);
  GridPaths out;
  out.reserve(grown.size());
  for (const Path& path : grown) out.push_back(from_clipper(path));
  return out;
}

std::vector<GridPaths> combine(const GridPaths& subject, const GridPaths& clip, Combine how) {
  ClipperLib::Clipper clipper;
  clipper.AddPaths(to_clipper(subject), ClipperLib::ptSubject, true);
  clipper.AddPaths(to_clipper(clip), ClipperLib::ptClip, true);
  ClipperLib::PolyTree tree;
  clipper.Execute(clip_type(how), tree, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
  std::vector<GridPaths> out;
  parts_below(tree, out);
  return out;
}

double area_of(const GridPath& path) {
  double twice = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const GridPoint &a = path[i], &b = path[i + 1 < path.size() ? i + 1 : 0];
    twice += (double(a.x) + double(b.x)) * (double(b.y) - double(a.y));
  }
  return 0.5 * twice;
}

double area_of(const GridPaths& paths) {
  double sum = 0;
  for (const GridPath& path : paths) sum += area_of(path);
  return sum;
}

}  // namespace atrium
