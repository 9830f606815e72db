// Import: scene files to a Scene. Polygons stay polygons: coplanar pieces are rejoined into large
// convex surfaces, and where coplanar faces overlap one of them counts. Everything dropped, cut or
// decided is counted and named in Scene::warnings; what cannot be read is a Status with its place.
// Deterministic; no global state; safe to call from any thread.
#pragma once

#include <string>
#include <vector>

#include "engine/scene.h"
#include "engine/status.h"

namespace atrium {

// --sides: which sides of surfaces receive, reflect and emit.
enum class SidesChoice {
  kAuto,  // closed shells their outside (rooms their inside), everything else both
  kOne,   // the front; the back is opaque and black
  kTwo    // both
};

struct ImportOptions {
  std::vector<std::string> files;  // .obj, .gltf, .glb: one scene
  std::string assign_file;         // TOML, "" for none
  std::vector<std::string> drop;   // regular expressions searched for in object names
  SidesChoice sides = SidesChoice::kAuto;
  double unit = 1;                    // metres a file unit
  bool emission_is_exitance = false;  // Ke is M in lm/m², not L in cd/m²
  double white = 0.9;                 // what a reflectance of exactly 1 is taken as, in [0, 1)
};

Result<Scene> import_scene(const ImportOptions& options);

}  // namespace atrium
