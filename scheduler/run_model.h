// RunModel to bytes and back: the records under which a run keeps names, frame and partition, in
// pieces that fit a small arena.
// Little endian, arrays as a u64 count and their items; layout in pagestore/FORMAT.md.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/solution.h"

namespace atrium {

inline constexpr std::size_t kRunModelPiece = std::size_t{256} << 10;  // bytes of payload

std::vector<std::byte> to_bytes(RunModel run);
Status store_run_model(std::span<const std::byte> bytes, ClusterStore& store);
// Errors: kUsage where the store holds none yet, kStore where it is broken.
Result<RunModel> load_run_model(ClusterStore& store, const std::string& directory);

}  // namespace atrium
