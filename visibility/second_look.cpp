#include "visibility/second_look.h"

#include <algorithm>
#include <cmath>

#include "visibility/bsp.h"
#include "visibility/contact.h"

namespace atrium {

namespace {

// The tree knows boxes: of a long segment it is asked piece by piece.
constexpr double kPieceOfDiagonal = 1.0 / 64;

// The stretch [from, to] of a segment where a function that is `a` at its start and `b` at its end
// is not negative.
struct Stretch {
  double from, to;
  bool keep(double a, double b) {
    if (a < 0 && b < 0) return false;
    if (a < 0) from = std::max(from, a / (a - b));
    if (b < 0) to = std::min(to, a / (a - b));
    return from <= to;
  }
};

// Does the stretch of the segment meet the prism around the polygon, `width` in every direction?
// [Cyrus & Beck 78]
bool meets(PolygonView corners, const Plane& plane, double width, const Vec3& x, const Vec3& y,
           Stretch stretch) {
  const double a = plane.distance(x), b = plane.distance(y);
  if (!stretch.keep(a + width, b + width) || !stretch.keep(width - a, width - b)) return false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 edge = corners[(i + 1) % corners.size()] - corners[i];
    const double l = length(edge);
    if (!(l > 0)) continue;
    const Vec3 inward = cross(plane.normal, edge) / l;
    if (!stretch.keep(dot(inward, x - corners[i]) + width, dot(inward, y - corners[i]) + width))
      return false;
  }
  return true;
}

}  // namespace

SecondLook::SecondLook(const Scene& scene)
    : scene_(scene),
      tree_(surface_tree(scene)),
      near_(kNearOfDiagonal * scene.bounds.diagonal()),
      width_(kSliverTolerances * scene.tolerance),
      piece_(kPieceOfDiagonal * scene.bounds.diagonal()) {
  planes_.reserve(scene.surfaces.size());
  for (const Surface& s : scene.surfaces) planes_.push_back(plane_of(scene.polygon(s)));
}

// By the tolerance and no more: what is higher may hide all that is below it.
bool SecondLook::rises(std::uint32_t surface, const Plane& plane) const {
  return std::ranges::any_of(polygon(surface),
                             [&](const Vec3& v) { return plane.distance(v) > scene_.tolerance; });
}

bool SecondLook::crowded(const FacePoint& x) const {
  const Box box{x.at - Vec3{near_}, x.at + Vec3{near_}};
  bool found = false;
  tree_.visit(box, [&](std::uint32_t i) {
    found = found || (std::abs(planes_[i].distance(x.at)) <= near_ &&
                      contains(polygon(i), planes_[i].normal, x.at, near_) && rises(i, x.plane));
  });
  return found;
}

bool SecondLook::surely_free(const FacePoint& x, const FacePoint& y) const {
  const Vec3 along = y.at - x.at;
  const int pieces = std::max(1, static_cast<int>(std::ceil(length(along) / piece_)));
  bool touched = false;
  for (int k = 0; k < pieces && !touched; ++k) {
    Box box;
    box.extend(x.at + (double(k) / pieces) * along);
    box.extend(x.at + (double(k + 1) / pieces) * along);
    box.lo -= Vec3{width_};
    box.hi += Vec3{width_};
    tree_.visit(box, [&](std::uint32_t i) {
      touched = touched || (touches(i, x.at, y.at) && rises(i, x.plane) && rises(i, y.plane));
    });
  }
  return !touched;
}

bool SecondLook::touches(std::uint32_t surface, const Vec3& x, const Vec3& y) const {
  const double margin = near_ / length(y - x);
  return meets(polygon(surface), planes_[surface], width_, x, y, {margin, 1 - margin});
}

bool SecondLook::passes(PolygonView polygon, const Vec3& x, const Vec3& y) const {
  return meets(polygon, plane_of(polygon), width_, x, y, {0, 1});
}

std::optional<FacePoint> SecondLook::sure_crossing(const Vec3& x, const Vec3& y,
                                                   SurfaceId surface) const {
  const Plane& plane = planes_[surface.value];
  const double a = plane.distance(x), b = plane.distance(y);
  if (!(std::min(std::abs(a), std::abs(b)) > width_) || (a > 0) == (b > 0)) return {};
  const Vec3 z = x + (a / (a - b)) * (y - x);
  if (std::min(length(z - x), length(z - y)) <= near_) return {};
  if (!contains(polygon(surface.value), plane.normal, z, -width_)) return {};
  return FacePoint{z, a > 0 ? plane : plane.flipped()};
}

}  // namespace atrium
