// Form factors of planar polygons, unoccluded: the share of the light leaving one that arrives at
// the other. Between a point and a polygon by Lambert's contour formula; between two polygons by
// the double contour integral, or by adaptive cubature of the kernel where that would cancel.
//
// A polygon is simple and planar, concave or convex, counter-clockwise seen from its front. What
// lies behind the other's plane gives and gets nothing. All functions are pure, any thread.
#pragma once

#include <string>
#include <string_view>

#include "engine/geometry.h"
#include "engine/status.h"

namespace atrium {

// The configuration factor from a surface point x with unit normal n to the polygon's front:
// (1/π) ∫ cosθ dω over the polygon above the point's horizon, in [0, 1]. Relative error below 1e-8,
// however small, far or grazing the polygon, as far as the coordinates carry it. In the polygon's
// own plane 0; on its rim the limit from its front within the point's own plane.
double point_to_polygon(const Vec3& x, const Vec3& n, PolygonView polygon);

// The same with an absolute error below 1e-13 instead: all that a sum of factors can use. What is
// far or nearly in the horizon costs hundreds of times less.
double point_to_polygon_in_sum(const Vec3& x, const Vec3& n, PolygonView polygon);

struct PolygonFormFactors {
  double f12, f21;  // of the whole polygons, what is clipped away included
  double a1, a2;    // areas; a1 f12 = a2 f21
};

// Relative error below 1e-6, usually 1e-9, down to form factors of 1e-12 for polygons that touch
// and of any size for those that do not. kUsage, naming "polygon 1" or "polygon 2", for what
// check_polygon refuses.
Result<PolygonFormFactors> polygon_to_polygon(PolygonView p1, PolygonView p2);

// Finite, of at least three corners, with area, planar, and not crossing itself? If not, kUsage
// with `name` in the file's place.
Status check_polygon(PolygonView polygon, const std::string& name);

// "x y z;x y z;x y z..." with at least three corners, strictly: numbers as in C without a plus
// sign, finite, apart by blanks, and nothing else.
Result<Polygon> parse_polygon(std::string_view text);

struct SurfacePoint {
  Vec3 x{0};
  Vec3 normal{0};  // unit
};

// "x y z;nx ny nz", the normal of any length but zero.
Result<SurfacePoint> parse_point(std::string_view text);

}  // namespace atrium
