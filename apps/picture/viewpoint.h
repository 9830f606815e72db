// Viewpoints that make a good picture by themselves: inside a lit room, or overhead with the
// ceiling left out.
#pragma once

#include <optional>

#include "apps/picture/camera.h"
#include "apps/picture/lit_scene.h"

namespace atrium {

// The coordinate axis that is up: against the way the lamps' fronts shine; z where they shine all
// ways.
Result<Vec3> up_direction(Solution& solution);

// The view from eye height that shows most and reaches furthest, among those from the corners and
// sides of the largest lit rooms; a single box with little in it is looked into from outside.
Result<Camera> interior_view(LitScene& scene, const Vec3& up, double fov, double aspect);

struct Overhead {
  Camera camera;
  Plane cut;      // what lies above it is left out
  double aspect;  // width ÷ height that the scene fills
};
// cut_height: m along `up`, internal frame; without it, below the ceiling of the topmost storey.
Overhead overhead_view(const RunModel& run, const Vec3& up, double fov,
                       std::optional<double> cut_height, std::optional<double> aspect);

}  // namespace atrium
