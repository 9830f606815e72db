#include "visibility/seen_part.h"

#include <algorithm>
#include <cmath>

namespace atrium {

namespace {

// The planes through x that bound what a blocker hides from there, facing into it.
struct Pyramid {
  std::array<Plane, ConvexPiece::kMaxCorners> planes;
  std::size_t count = 0;
  bool fits = true;
  std::span<const Plane> sides() const { return {planes.data(), count}; }
};

// The blocker's part between x and the target's plane.
ConvexPiece part_between(const Vec3& x, PolygonView blocker, const Plane& target, double tolerance,
                         bool& fits) {
  ConvexPiece whole;
  fits = blocker.size() <= ConvexPiece::kMaxCorners;
  if (!fits) return whole;
  whole.corners = blocker.size();
  std::copy(blocker.begin(), blocker.end(), whole.at.begin());
  const Plane above{target.normal, target.offset + tolerance};
  const Plane below{-target.normal, tolerance - dot(target.normal, x)};
  return in_front(in_front(whole, above, fits), below, fits);
}

Pyramid pyramid_over(const Vec3& x, PolygonView blocker, const Plane& target, double tolerance) {
  Pyramid out;
  const ConvexPiece base = part_between(x, blocker, target, tolerance, out.fits);
  if (!out.fits) return out;
  Vec3 middle{0};
  for (const Vec3& corner : base.polygon()) middle += (corner - x) / double(base.corners);
  for (std::size_t i = 0; i < base.corners; ++i) {
    const Vec3& a = base.at[i];
    const Vec3& b = base.at[i + 1 < base.corners ? i + 1 : 0];
    const Vec3 across = cross(a - x, b - x);
    const double size = length(across);
    if (!(size > 0)) continue;  // an edge seen end on
    const Vec3 inward = across * ((dot(across, middle) < 0 ? -1 : 1) / size);
    out.planes[out.count++] = {inward, dot(inward, x)};
  }
  return out;
}

}  // namespace

Remainder seen_part(const Vec3& x, PolygonView target, const Vec3& normal,
                    const BlockerList& list) {
  const Plane plane{normal, dot(normal, target[0])};
  Remainder out(target);
  if (!(plane.distance(x) > 2 * list.tolerance)) out.clear();
  for (const std::uint32_t position : list.positions) {
    if (out.overflow || out.count == 0) break;
    const PolygonView blocker = list.blockers[position].polygon;
    if (std::abs(plane_of(blocker).distance(x)) <= list.tolerance) continue;  // seen edge on
    const Pyramid pyramid = pyramid_over(x, blocker, plane, list.tolerance);
    out.overflow = out.overflow || !pyramid.fits;
    if (pyramid.count >= 3) out.cut_out(pyramid.sides(), list.tolerance);
  }
  return out;
}

}  // namespace atrium
