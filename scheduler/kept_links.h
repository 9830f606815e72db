// KeptLinks: the braids of a level of the iteration, by receiver, made in its first sweep and used
// in all others; those of the level before until their receiver's new ones take their place, for
// what a finer level would make the same it takes from them. As many as fit the budget stay in
// memory; the others are streamed from the page store whenever their receiver comes round. None is
// made again before the next level: that would cost a hundred times what reading it does, and what
// is made later, of other light, is not the same. The paper discards links and makes them again
// [THFH94 §5.1 3(f)]: memory was 256 MB, and a disk is now faster than refining is.
//
// Invariants:
//  1. What comes back is what was kept, bit for bit, wherever it was: the budget changes no result.
//  2. After save(), a checkpoint holds all braids kept so far.
// Not thread safe.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/id.h"
#include "engine/status.h"
#include "pagestore/cluster_store.h"
#include "solver/link.h"

namespace atrium {

// What became of the braids of a level.
struct LinksKept {
  std::uint64_t in_memory = 0, in_memory_bytes = 0;  // clusters, and what their braids take
  std::uint64_t streamed = 0, streamed_bytes = 0;    // from disk, each time their receiver comes
};

class KeptLinks {
 public:
  KeptLinks(ClusterStore& store, std::size_t clusters);

  // Bytes of memory from now on. Where braids take more, the last receivers' go to disk.
  Status fit(std::uint64_t budget, std::span<const ClusterId> order);

  // Of this level?
  bool has(ClusterId receiver) const {
    const Kept& kept = kept_[receiver.value];
    return (kept.braids || kept.on_disk) && !kept.past;
  }
  // The receiver's braids: valid until the next call. kStore: the disk.
  Result<std::vector<Braid>*> of(ClusterId receiver);
  // Across the braid with its i-th source: has the receiver anything to gather? Where that is not
  // known, since an earlier process made the braids, it has.
  bool carries_light(ClusterId receiver, std::size_t i) const {
    const std::vector<bool>& carrying = kept_[receiver.value].carrying;
    return carrying.empty() || carrying[i];
  }
  // Those of the level before; none where there are none. Valid until the next call.
  Result<std::span<const Braid>> past(ClusterId receiver);
  // In place of those of the level before; on error these stay.
  Status keep(ClusterId receiver, std::vector<Braid> braids);
  Status save();
  void forget(ClusterId receiver);  // that is not gathered to after all
  void forget_all();
  void become_past(ClusterId receiver);  // a new level has begun

  LinksKept kept() const;

 private:
  struct Kept {
    std::optional<std::vector<Braid>> braids{};  // in memory
    std::uint64_t bytes = 0;                     // of memory, wherever they are
    bool on_disk = false;
    bool past = false;  // of the level before
    std::vector<bool> carrying{};  // by source
  };
  Result<std::vector<Braid>*> bring(ClusterId receiver);
  Status write(ClusterId receiver, std::span<const Braid> braids);

  ClusterStore& store_;
  std::uint64_t budget_ = 0, bytes_ = 0;
  std::vector<Kept> kept_;
  std::vector<Braid> streamed_;  // those of the last receiver that was not in memory
};

}  // namespace atrium
