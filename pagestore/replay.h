// Replay: a trace driven against a real store on disk, in real seconds. Every record brought in is
// compared, byte by byte, with what was last written to it; that is not counted as time.
#pragma once

#include <cstdint>
#include <string>

#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "pagestore/simulate.h"
#include "pagestore/trace.h"

namespace atrium {

struct ReplayOptions {
  std::string directory;  // made; kUsage if it holds a store
  std::uint64_t arena = 0;
  std::string policy = "lru";
  Io io = Io::kMmap;
};

struct Replay {
  Simulation counts;  // as counted by the store; seconds are those of the replay, the final flush
                      // included, the making of the store not
  std::uint64_t fragmentation_evictions = 0;  // beyond the simulated ones
  double io_seconds = 0;
};

// kStore: the disk, or a record that came back other than it was written. kUsage: no such policy;
// an arena below the smallest feasible one.
Result<Replay> replay(const Trace& trace, const ReplayOptions& options);

}  // namespace atrium
