// Sealed solids: convex shells that no light enters, closed by themselves or by what they stand on
// or against: a box on a floor, a pipe from floor to ceiling. What faces the inside of one, its own
// faces from behind, what it covers of a floor, what stands in it, is dark whatever stands outside:
// inert, though it blocks all the same. Left to the solver the inside is a cavity that light leaks
// into by the errors of its rows, and hardly out of: white ones (ρ = .98) were half as bright as
// the room, and at ρ = .999 no coarse system brought them to rest.
//
// Errs towards light: a shell that is not convex, whose edges do not meet end to end, that stands
// across the joint of two surfaces, or next to a lamp, is not sealed. Pure; safe from any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry.h"
#include "engine/scene.h"
#include "visibility/box_tree.h"

namespace atrium {

class SealedSolids {
 public:
  // surfaces: the tree of all surfaces' boxes. of_object: by object, those that are its own.
  SealedSolids(const Scene& scene, const BoxTree& surfaces,
               std::span<const std::vector<std::uint32_t>> of_object);

  // Is all that a polygon, counter-clockwise, faces close by within one solid?
  bool darken(PolygonView polygon) const;

 private:
  std::vector<std::vector<Plane>> solids_;  // the planes of each, outwards
  BoxTree boxes_;                           // theirs
  double tolerance_;
};

}  // namespace atrium
