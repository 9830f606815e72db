// A second look at single segments, in double and against all surfaces: what rays in float said is
// believed where it holds here too. Each answer is given where it is certain and else withheld, so
// that a judge who asks accuses nobody wrongly.
//
// What a segment alone could get wrong, and how it is excluded:
//  1. Where a second face covers an end, closer than rays can tell, the segment starts or ends
//     behind it: such ends are crowded. [facts: visibility, a validator's own error] A face at or
//     behind an end's own plane covers nothing: real models are full of walls that share a face.
//  2. Rays slip between faces that meet without sharing corners, and cracks narrower than
//     kSliverTolerances are none by the scene's contract: a free segment keeps that distance from
//     all surfaces but those at or behind its ends' planes.
//  3. Faces are planar within the tolerance only: what passes through one for certain comes from
//     and goes to a greater distance of its plane, and passes that far within its edges.
// Immutable once built; any number of threads may ask.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/geometry.h"
#include "engine/scene.h"
#include "visibility/box_tree.h"

namespace atrium {

// Faces nearer to each other than this share of the scene's diagonal are not told apart at an end.
inline constexpr double kNearOfDiagonal = 1e-5;

// A point of a surface, and its plane, facing the side that is meant.
struct FacePoint {
  Vec3 at{0};
  Plane plane;
};

class SecondLook {
 public:
  explicit SecondLook(const Scene& scene);

  double near() const { return near_; }    // m, of kNearOfDiagonal
  double width() const { return width_; }  // m, of kSliverTolerances

  // Does another face cover the point, or stand on its plane, within near() of it?
  bool crowded(const FacePoint& x) const;

  // Is the segment free for certain?
  bool surely_free(const FacePoint& x, const FacePoint& y) const;

  // Does the segment come to within width() of a polygon that is no surface?
  bool passes(PolygonView polygon, const Vec3& x, const Vec3& y) const;

  // Where the segment passes through the surface, if it does so for certain: there, with the plane
  // facing x.
  std::optional<FacePoint> sure_crossing(const Vec3& x, const Vec3& y, SurfaceId surface) const;

 private:
  bool touches(std::uint32_t surface, const Vec3& x, const Vec3& y) const;
  bool rises(std::uint32_t surface, const Plane& plane) const;
  PolygonView polygon(std::uint32_t surface) const {
    return scene_.polygon(scene_.surfaces[surface]);
  }

  const Scene& scene_;
  BoxTree tree_;
  std::vector<Plane> planes_;
  double near_ = 0, width_ = 0;
  double piece_ = 0;  // m, of a segment, that the tree is asked for at a time
};

}  // namespace atrium
