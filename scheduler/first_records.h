// First records: the database as it is before the first gather, and what tells it from another.
// Pure functions but for the store.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "scheduler/plan.h"

namespace atrium {

using TreesOf = std::function<Result<std::vector<PatchTree>>(ClusterId)>;

// Every cluster's record, elements of this basis, and the model. trees_of: what each begins with;
// null: patches of one element, without light.
Status write_first_records(const Prepared& prepared, int basis, ClusterStore& store,
                           const TreesOf& trees_of = {});

// Tells one partitioned scene from another: shapes, who sees whom, and how all of it reflects and
// emits.
std::uint64_t fingerprint(const Scene& scene, const Model& model);

}  // namespace atrium
