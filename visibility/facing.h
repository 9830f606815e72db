// Do clusters face each other at all? Patches see only what rises in front of their planes, and
// black backs are looked at by others but do not look at each other.
// Pure; safe from any thread.
#pragma once

#include <vector>

#include "engine/model.h"

namespace atrium {

class Facing {
 public:
  explicit Facing(const Model& model);

  // May some patch of one cluster and some patch of the other see each other, going by their
  // planes alone? Conservative.
  bool may_see(std::uint32_t c, std::uint32_t d) const;

 private:
  bool rises(const Box& box, const Plane& plane) const;
  bool rises(std::uint32_t patch, const Plane& plane) const;
  bool faces_box(std::uint32_t cluster, const Box& box) const;

  const Model& model_;
  std::vector<Plane> planes_;  // of patches
};

}  // namespace atrium
