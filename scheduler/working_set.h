// Working set: what a gather needs in memory at once. The receiver's trees, taken out of its record;
// the blockers of all that stands in cells it can see, with their shaft index and ray structure; one
// source at a time, pinned in the arena. [THFH94 §4 figure 2, §5]
//
// Receivers of one room share a RayWorld, of all that anything in the room may see; which one a
// receiver uses is a function of the model alone, never of arena, threads or history.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/model.h"
#include "pagestore/cluster_store.h"
#include "scheduler/blocker_record.h"
#include "solver/refine.h"

namespace atrium {

// Blockers of a set of clusters, ready to be asked.
class RayWorld {
 public:
  static Result<std::unique_ptr<RayWorld>> build(ClusterStore& store,
                                                 std::span<const ClusterId> clusters);

  Surroundings surroundings() const { return {&*index_, &*rays_}; }
  std::size_t bytes() const;
  std::size_t polygons() const { return polygons_.size(); }

 private:
  RayWorld() = default;
  BlockerSet set_;
  std::vector<BlockerPolygon> polygons_;
  std::optional<BlockerIndex> index_;
  std::optional<RayScene> rays_;
};

// The last few rooms' ray worlds.
class RayWorlds {
 public:
  RayWorlds(const Model& model, ClusterStore& store);
  Result<const RayWorld*> of(ClusterId receiver);
  std::size_t bytes() const;

 private:
  static constexpr std::size_t kKept = 4;
  struct Entry {
    std::uint32_t room = 0;
    std::unique_ptr<RayWorld> world;
  };
  std::vector<ClusterId> seen_from(std::uint32_t room) const;

  const Model& model_;
  ClusterStore& store_;
  Rows<ClusterId> clusters_of_room_;
  std::vector<Entry> kept_;  // the last used first
};

}  // namespace atrium
