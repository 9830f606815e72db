// Which sides of faces receive, reflect and emit (--sides). `auto` looks at the model:
//  - a closed, consistently oriented shell has one side, its front: the outside of a solid, the
//    inside of a room. A shell turned inside out that holds nothing, or one that encloses a lamp,
//    gets both, for its fronts alone would leave it dark;
//  - an open sheet has both sides;
//  - what --assign says of a material stands above this, and so does glTF's doubleSided.
#pragma once

#include <vector>

#include "engine/import/convex_pieces.h"
#include "engine/import/import.h"
#include "engine/import/mesh.h"

namespace atrium {

// Sets Face::sides. `rings` as from enter_junctions for each object.
void decide_sides(Mesh& mesh, const std::vector<Ring>& rings,
                  const std::vector<std::vector<std::uint32_t>>& by_object, const RawModel& model,
                  const std::vector<Material>& materials, SidesChoice choice, WarningLog& warnings);

}  // namespace atrium
