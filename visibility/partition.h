// Partition: from a scene to the model that the solve works on. [THFH94 §5] Cells and portals, the
// space that light can reach, patches cut at walls, clusters by object and room, contacts, and the
// global oracle's rows. Deterministic; safe to call from any thread.
#pragma once

#include "engine/model.h"
#include "engine/scene.h"
#include "engine/status.h"

namespace atrium {

struct PartitionOptions {
  std::uint32_t most_patches_of_cluster = 1024;  // an object with more in a room is halved
  double close_gaps = 0;  // m, openings up to so wide count as closed (visibility/gap.h)
};

// What a partition found, for reports.
struct PartitionCounts {
  std::uint64_t splits = 0;  // planes of the subdivision
  std::uint64_t lit_cells = 0;
  std::uint64_t lit_sides = 0;    // sides of surfaces that count and that light can reach
  std::uint64_t lit_patches = 0;  // patches of them: how much the walls cut
  std::uint64_t inert_patches = 0;
  std::uint64_t visible_pairs = 0;  // ordered, self-pairs included
};
PartitionCounts count(const Model& model);

// Fails with kScene where no surface emits.
Result<Model> partition(const Scene& scene, const PartitionOptions& options = {});

}  // namespace atrium
