// The plan: a scene made ready to be solved, what its solution will take, and what it does not need
// and is left out. [the user's wish: leave out what a given scene does not need]
#pragma once

#include "engine/model.h"
#include "engine/scene.h"
#include "scheduler/solve.h"

namespace atrium {

// What the solve scales its tolerances by, measured on the model before the first gather.
struct LightScale {
  double flux = 0;             // lm emitted
  double area = 0;             // m² of lit surfaces that receive
  double reflectance = 0;      // luminance, area mean
  double exitance_norm = 0;    // ‖M‖, L2 over area, luminance
  double irradiance = 0;       // lx, a first guess of the mean
  double radiosity = 0;        // lm/m², likewise
  double reference_area = 0;   // m², lit area that a surface may see, area mean
};

struct Prepared {
  Scene scene;
  Model model;
  LightScale light;
  Plan plan;
  std::uint64_t bytes = 0;  // of memory, what stays as it is through the solve
};

// Import, partition and plan. Errors: kUsage, kScene.
Result<Prepared> prepare(const SolveOptions& options);

// Options that contradict themselves or the machine: kUsage.
Status validate(const SolveOptions& options);
// kUsage; in bytes.
Status budget_too_small(const char* option, std::uint64_t given, std::uint64_t smallest);

// The features that --force switches on: ray structures in convex empty rooms; face groups in
// clusters that are not dense.
inline constexpr char kRays[] = "rays";
inline constexpr char kGroups[] = "groups";
bool forces(const SolveOptions& options, const std::string& feature);

}  // namespace atrium
