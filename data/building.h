// Floor and Building of the paper's Table 3, bigger ones, and several side by side.
#pragma once

#include "data/furniture.h"
#include "data/shapes.h"

namespace atrium::generator {

struct BuildingOptions {
  int storeys = 1;
  int rooms = 0;  // at least so many on a storey; 0: as in the paper's models
  int buildings = 1;
  Furnish furnish = Furnish::kNone;
  std::uint64_t seed = 1;
};

// One storey has the paper's Floor for its measure, several the paper's Building: clusters, patches
// and lights in the same proportion to the storeys' size.
GeneratedModel building(const BuildingOptions& options, const std::string& title);

}  // namespace atrium::generator
