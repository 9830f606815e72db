// What a solution is exported as. Each writes one file; equal solutions give equal bytes.
#pragma once

#include <cstdint>
#include <string>

#include "apps/export/surface_mesh.h"
#include "engine/status.h"

namespace atrium {

struct Exported {
  std::uint64_t bytes = 0, vertices = 0, faces = 0;
};

// glTF 2.0 in one binary file: a node and a mesh for each object, in metres, with the scene's own
// axes. Corners carry COLOR_0, linear 0..1 as the automatic exposure shows it, and _RADIOSITY,
// exact, lm/m². Materials are unlit. Positions are relative to the root node, which stands at whole
// multiples of 1024 m, so that floats keep a tenth of a millimetre wherever the scene lies.
Result<Exported> write_glb(const SurfaceMesh& mesh, const std::string& path);

// PLY 1.0, binary little-endian: x, y, z in metres (double, the files' frame), red, green, blue as
// the automatic exposure shows them (sRGB), and radiosity_r, _g, _b, exact (float, lm/m²).
Result<Exported> write_ply(const SurfaceMesh& mesh, const std::string& path);

// A row for each leaf element: cluster, patch, centroid (the scene's units), normal, area in m²,
// the element's mean E and B. Its header is one that `atrium probe` reads.
Result<Exported> write_csv(Solution& solution, const std::string& path);

}  // namespace atrium
