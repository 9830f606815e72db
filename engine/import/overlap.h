// Coplanar overlaps: on either side of a plane one surface counts at each point: fronts before
// backs, then emitters, then the first in the files. What loses is cut off by polygon difference;
// what is left of a side falls into convex surfaces. Where a patch's sides keep different parts,
// they become surfaces of one side each, so that a side that lost nothing stays whole.
#pragma once

#include <vector>

#include "engine/import/mesh.h"
#include "engine/import/rejoin.h"
#include "engine/scene.h"

namespace atrium {

// Fills in the scene's surfaces, vertices, patches and lights (patches of which nothing is left do
// not count).
void resolve_overlaps(const Mesh& mesh, const std::vector<PatchRing>& patches,
                      const RawModel& model, Scene& scene, WarningLog& warnings);

}  // namespace atrium
