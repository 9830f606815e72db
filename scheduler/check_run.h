// check_run: verifies all that a run directory holds. The page store: both roots, and every record
// that they name, by hash; of the newest, that each parses as what it is and none is missing. The
// run's texts by the sums in the newest state; lines of history that came later, as JSON. The
// status page by its hash.
//
// What it leaves out: free space of the page store, whose bytes mean nothing; lines of run.log that
// came after the last checkpoint; the lock.
//
// It takes no lock and may look at a live run: overtaken by its checkpoints, it begins again. Not
// thread safe.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/status.h"

namespace atrium {

struct CheckedRecords {
  std::string kind;                    // "cluster"
  std::uint64_t count = 0, bytes = 0;  // of payload
};

struct RunCheck {
  bool begun = false;  // the first records are there
  std::uint64_t epoch = 0, roots = 0;
  std::vector<CheckedRecords> records;  // of the newest root, kinds that there are
  std::uint64_t summed_bytes = 0;       // of texts, that match their sums
  std::uint64_t unsummed_bytes = 0;     // of texts, since the last checkpoint
};

// kUsage: no run directory. kStore: the first fault found, with its file and place.
Result<RunCheck> check_run(const std::string& directory);

}  // namespace atrium
