// Rejoining: the coplanar faces of one object that share edges, material and sides become few large
// convex patches, for hierarchical radiosity lives on large ones. Exports of solids arrive as
// triangles; what a modeller drew as a wall should be one again.
//
// A region is rejoined only where that makes fewer pieces than its faces had; its corners are the
// faces' own vertices, so that neighbours share edges exactly; its area is kept.
#pragma once

#include <vector>

#include "engine/import/convex_pieces.h"
#include "engine/import/mesh.h"

namespace atrium {

struct PatchRing {
  Ring ring;  // convex, counter-clockwise; vertices of the mesh
  ObjectId object;
  MaterialId material;
  std::uint8_t sides = kNoSide;
  std::uint32_t raw = 0;  // the first of its faces in the files
};

// Patches in the files' order. Cuts may add vertices to the mesh. `rings`: the faces' corners with
// the junctions of neighbours entered (see topology.h).
std::vector<PatchRing> rejoin(Mesh& mesh, const std::vector<Ring>& rings, const RawModel& model,
                              WarningLog& warnings);

}  // namespace atrium
