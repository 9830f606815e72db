#include "scheduler/working_set.h"

#include <algorithm>

namespace atrium {

Result<std::unique_ptr<RayWorld>> RayWorld::build(ClusterStore& store,
                                                  std::span<const ClusterId> clusters) {
  std::unique_ptr<RayWorld> world(new RayWorld);
  for (const ClusterId id : clusters) {
    Result<ClusterPin> pin = store.read(record_id(RecordKind::kBlockers, id.value));
    if (!pin.ok()) return pin.status();
    ATRIUM_RETURN_IF_ERROR(append_blockers(pin->bytes(), world->set_));
  }
  for (const BlockerSet::Item& item : world->set_.items)
    world->polygons_.push_back({world->set_.polygon(item), item.patch});
  world->index_.emplace(world->polygons_);
  world->rays_.emplace(world->polygons_);
  return world;
}

std::size_t RayWorld::bytes() const {
  return set_.items.size() * sizeof(BlockerSet::Item) + set_.vertices.size() * sizeof(Vec3) +
         polygons_.size() * sizeof(BlockerPolygon) + index_->bytes() + rays_->bytes();
}

RayWorlds::RayWorlds(const Model& model, ClusterStore& store) : model_(model), store_(store) {
  std::vector<std::vector<ClusterId>> rows(model.rooms);
  for (std::size_t c = 0; c < model.clusters.size(); ++c)
    rows[model.clusters[c].room].push_back(ClusterId(c));
  for (const std::vector<ClusterId>& row : rows) clusters_of_room_.push_row(row);
}

// All that anything in the room may see, and the room's own clusters, which block whether they are
// seen or not.
std::vector<ClusterId> RayWorlds::seen_from(std::uint32_t room) const {
  std::vector<ClusterId> seen;
  for (const ClusterId c : clusters_of_room_[room]) {
    seen.push_back(c);
    const std::span<const ClusterId> visible = model_.visible[c.value];
    seen.insert(seen.end(), visible.begin(), visible.end());
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  return seen;
}

Result<const RayWorld*> RayWorlds::of(ClusterId receiver) {
  const std::uint32_t room = model_.clusters[receiver.value].room;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    if (kept_[i].room == room) {
      std::rotate(kept_.begin(), kept_.begin() + i, kept_.begin() + i + 1);
      return static_cast<const RayWorld*>(kept_[0].world.get());
    }
  if (kept_.size() == kKept) kept_.pop_back();
  Result<std::unique_ptr<RayWorld>> world = RayWorld::build(store_, seen_from(room));
  if (!world.ok()) return world.status();
  kept_.insert(kept_.begin(), {room, std::move(world).value()});
  return static_cast<const RayWorld*>(kept_[0].world.get());
}

std::size_t RayWorlds::bytes() const {
  std::size_t sum = 0;
  for (const Entry& e : kept_) sum += e.world->bytes();
  return sum;
}

}  // namespace atrium
