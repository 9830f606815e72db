// Planes, boxes and convex polygons in space. Polygons are spans of vertices, counter-clockwise
// seen from the side their normal points to. All functions are pure; tolerances are absolute
// lengths that the caller derives from its scene's size.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "engine/vec.h"

namespace atrium {

struct Plane {
  Vec3 normal{0, 0, 1};  // unit
  double offset = 0;     // dot(normal, x) = offset on the plane
  double distance(const Vec3& x) const { return dot(normal, x) - offset; }
  Plane flipped() const { return {-normal, -offset}; }
};

struct Box {
  Vec3 lo{std::numeric_limits<double>::infinity()};
  Vec3 hi{-std::numeric_limits<double>::infinity()};
  bool empty() const { return !(lo.x <= hi.x); }
  void extend(const Vec3& x);
  void extend(const Box& b);
  Vec3 center() const { return 0.5 * (lo + hi); }
  Vec3 extent() const { return hi - lo; }
  double diagonal() const { return empty() ? 0 : length(extent()); }
  bool overlaps(const Box& b, double margin = 0) const;
  bool contains(const Vec3& x, double margin = 0) const;
};

using Polygon = std::vector<Vec3>;
using PolygonView = std::span<const Vec3>;

Box bounds(PolygonView points);

// Newell's normal, its length twice the area; right for any simple polygon.
Vec3 area_vector(PolygonView polygon);
double area(PolygonView polygon);     // m²
Vec3 centroid(PolygonView polygon);   // of the area, planar polygons
Plane plane_of(PolygonView polygon);  // through the vertices' mean; normal zero if the area is

// The largest distance of a vertex from plane_of(polygon).
double planarity(PolygonView polygon);

// The part of a convex polygon where plane.distance(x) >= 0; empty if nothing of area is left.
// Vertices within `tolerance` of the plane count as on it.
Polygon clip(PolygonView polygon, const Plane& plane, double tolerance);

struct Split {
  Polygon front, back;  // either may be empty
};
Split split(PolygonView polygon, const Plane& plane, double tolerance);

// Is x, a point in the convex polygon's plane, inside it or within `tolerance` of it?
bool contains(PolygonView polygon, const Vec3& normal, const Vec3& x, double tolerance);

// From x to the nearest point of a convex polygon.
double distance_to(PolygonView polygon, const Vec3& x);

// Is the polygon convex, going by its own normal, up to `tolerance` metres of dent?
bool is_convex(PolygonView polygon, double tolerance);

// An orthonormal frame: of a plane, that u and v lie in, or of space.
struct Frame {
  Vec3 origin{0};
  Vec3 u{1, 0, 0}, v{0, 1, 0}, n{0, 0, 1};
  Vec3 to_space(const Vec2& p) const { return origin + p.x * u + p.y * v; }
  Vec3 to_space(const Vec3& p) const { return origin + p.x * u + p.y * v + p.z * n; }
  Vec2 to_plane(const Vec3& x) const { return {dot(x - origin, u), dot(x - origin, v)}; }
  Vec3 to_frame(const Vec3& x) const {
    return {dot(x - origin, u), dot(x - origin, v), dot(x - origin, n)};
  }
};
Frame frame_of(PolygonView polygon);  // u along its longest edge, n its normal

// The box around points in the frame's own coordinates.
Box bounds(PolygonView points, const Frame& frame);

// A frame at the origin with this normal, u and v any. [Duff et al. 2017]
Frame frame_about(const Vec3& normal);

// Direction i of a cosine-weighted bundle about the frame's normal, unit length: a Fibonacci spiral
// over the disc, lifted. [Malley]
Vec3 cosine_direction(const Frame& frame, int i, int count);

// The unit square taken elsewhere so that points that are uniform and even there stay so: to
// directions, cosine-weighted about the frame's normal [Malley]; to a triangle or a convex polygon,
// by area.
Vec3 cosine_direction(const Frame& frame, const Vec2& square);  // unit
Vec3 point_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec2& square);
Vec3 point_of(PolygonView polygon, const Vec2& square);

// m², of the triangle between corners 0, i - 1 and i: a convex polygon is a fan of them.
double fan_area(PolygonView polygon, std::size_t i);

}  // namespace atrium
