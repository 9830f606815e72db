// A complete gather to one cluster: steps 1 to 7 of the paper's algorithm. [THFH94 §5.1]
//
//   1. Read R
//   2. Install R into working set
//   3. For each source cluster S visible to R: read S and blockers, tube, links, gather, release
//   4. PushPull each patch of R
//   5. Extract R   6. SetDirty R   7. Release R
//
// S is not dirtied (the paper's 3(i)): a source's finer levels are evaluated, never stored on it.
// One caller; inside, the receiver's patches are worked on by all threads, each patch or branch of
// a large one by one of them, in a fixed order of sources: the same bits for any number of threads.
// For that threads have enough to do, sources are installed a few at a time.
#pragma once

#include <vector>

#include "engine/model.h"
#include "pagestore/cluster_store.h"
#include "scheduler/equilibrium.h"
#include "scheduler/kept_links.h"
#include "scheduler/working_set.h"
#include "solver/gather.h"
#include "solver/push_pull.h"
#include "solver/refine.h"

namespace atrium {

// What a gather is to do with links.
enum class Linking {
  kMakeAndKeep,     // refine anew, keep the braids
  kMakeAndDiscard,  // refine anew, discard [THFH94 §5.1 3(f)]
  kUseKept
};

struct GatherTask {
  ClusterId receiver;
  Linking linking = Linking::kMakeAndDiscard;
  RefineSettings refine;
  double lamp_cap = 0;  // lm/m²: brighter sources do not stand for their room when rows are closed
  double over = 1;      // times what the gather changes, that is taken (solver/push_pull.h)
  KeptLinks* links = nullptr;  // filled or used, by `linking`
  Equilibrium* equilibrium = nullptr;
};

struct GatherReport {
  PushPullSums sums;
  RefineCounters refined;
  std::uint64_t elements = 0;   // of the receiver, afterwards
  std::uint64_t links = 0;      // gathered across
  std::uint64_t link_bytes = 0;
  std::uint64_t source_elements = 0;  // of all sources
  std::uint64_t working_set_bytes = 0;     // [THFH94 table 2]: links, elements, blockers
  std::uint64_t working_set_elements = 0;
  double solver_seconds = 0;
};

Result<GatherReport> gather_cluster(const Model& model, ClusterStore& store, RayWorlds& worlds,
                                    const GatherTask& task);

}  // namespace atrium
