// Points with normals as probe reads them: CSV with a header that names x,y,z,nx,ny,nz in any order
// among other columns, or the six numbers a line, with commas or blanks between them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/id.h"
#include "engine/spectrum.h"
#include "engine/status.h"

namespace atrium {

struct ProbePoint {
  Vec3 x{0};       // in the scene's units, as given
  Vec3 normal{0};  // as given: of any length but zero
};

// What stands there; ids are none and B is empty where the point is on no surface.
struct ProbeAnswer {
  Spectrum irradiance{0};             // lx
  std::optional<Spectrum> radiosity;  // lm/m²
  ClusterId cluster;
  CellId cell;
};

// file: for messages. Errors: kUsage, with the line.
Result<std::vector<ProbePoint>> parse_points(std::string_view text, const std::string& file);

}  // namespace atrium
