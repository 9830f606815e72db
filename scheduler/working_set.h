// Working set: what a gather needs in memory at once. The receiver's trees, taken out of its
// record; the blockers of all that stands in cells it can see, with their shaft index and ray
// structure; a few sources at a time, one of them pinned in the arena at the most. [THFH94 §4
// figure 2, §5]
//
// Blockers are the model's own polygons, which stay in memory: no record is read for them.
// Receivers of one room share a RayWorld, of all that anything in the room may see; which one a
// receiver uses is a function of the model alone, never of arena, threads or history.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/model.h"
#include "solver/refine.h"

namespace atrium {

// When rays are left out.
enum class RayUse { kWhereSomethingMayBlock, kAlways };

// A row a room: its clusters, which block whether they are seen or not, and all that they may see.
Rows<ClusterId> seen_from_rooms(const Model& model);

// Rooms in which nothing can stand between: rays are left out there.
std::uint32_t count_rooms_without_rays(const Model& model);

// Blockers of a set of clusters, ready to be asked; of a convex empty room their polygons alone.
// The model outlives it.
class RayWorld {
 public:
  RayWorld(const Model& model, std::span<const ClusterId> clusters, RayUse use);

  Surroundings surroundings() const {
    return index_ ? Surroundings{&*index_, &*rays_} : Surroundings{};
  }
  // All that the room's receivers may see, and what blocks.
  std::span<const BlockerPolygon> outlines() const { return polygons_; }
  std::size_t bytes() const;  // the polygons themselves with it

 private:
  std::vector<BlockerPolygon> polygons_;
  std::optional<BlockerIndex> index_;
  std::optional<RayScene> rays_;
};

// The last few rooms' ray worlds: one, and others as long as all take no more than the budget.
class RayWorlds {
 public:
  // budget: bytes.
  RayWorlds(const Model& model, RayUse use, std::size_t budget = std::size_t{64} << 20);
  const RayWorld& of(ClusterId receiver);  // until the next call
  std::size_t bytes() const;

 private:
  static constexpr std::size_t kKept = 4;
  struct Entry {
    std::uint32_t room = 0;
    std::unique_ptr<RayWorld> world;
  };
  const Model& model_;
  RayUse use_;
  std::size_t budget_;
  Rows<ClusterId> seen_from_room_;
  std::vector<Entry> kept_;  // the last used first
};

}  // namespace atrium
