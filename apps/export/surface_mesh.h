// Surface mesh: a solution as triangles with colours at their corners, object by object, for files
// that other programs read. Black backs of one-sided surfaces are left out.
//
// Invariants:
//  1. Objects come in the scene's order, their vertices and triangles are contiguous.
//  2. Equal solutions give equal meshes.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scheduler/solution.h"

namespace atrium {

struct MeshVertex {
  Vec3 x{0};              // m, internal frame
  Spectrum radiosity{0};  // lm/m²
};

struct MeshObject {
  std::string name;
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::uint32_t first_triangle = 0, triangle_count = 0;
};

struct SurfaceMesh {
  std::vector<MeshVertex> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;  // into the object's vertices
  std::vector<MeshObject> objects;
  Vec3 origin{0};       // m, of the internal frame in the files' frame
  double exposure = 0;  // EV at which the surfaces are well seen
};

// Errors: kStore; kUsage where 32-bit indices do not suffice.
Result<SurfaceMesh> surface_mesh(Solution& solution);

}  // namespace atrium
