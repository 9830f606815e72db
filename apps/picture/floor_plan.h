// A floor plan as SVG: a level section through a scene and its rooms. Surfaces are dark lines,
// cells thin outlines filled by room, portals green, lamps yellow outlines.
//
// A storey is a level on which much floor lies; the section runs a little above it.
// Pure functions; safe from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene.h"
#include "engine/status.h"
#include "visibility/leaks.h"

namespace atrium {

struct FloorPlanOptions {
  double height = 1.2;       // m, above the storey's floor
  std::uint64_t storey = 1;  // the lowest
};

// Errors: kUsage where there is no such storey.
Result<std::string> floor_plan_svg(const Scene& scene, const RoomPlan& plan,
                                   const FloorPlanOptions& options);

}  // namespace atrium
