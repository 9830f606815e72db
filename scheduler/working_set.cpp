#include "scheduler/working_set.h"

#include <algorithm>

namespace atrium {

Result<std::unique_ptr<RayWorld>> RayWorld::build(ClusterStore& store,
                                                  std::span<const ClusterId> clusters,
                                                  double tolerance, RayUse use) {
  std::unique_ptr<RayWorld> world(new RayWorld);
  for (const ClusterId id : clusters) {
    Result<ClusterPin> pin = store.read(record_id(RecordKind::kBlockers, id.value));
    if (!pin.ok()) return pin.status();
    ATRIUM_RETURN_IF_ERROR(append_blockers(pin->bytes(), world->set_));
  }
  for (const BlockerSet::Item& item : world->set_.items)
    world->polygons_.push_back({world->set_.polygon(item), item.patch});
  if (use != RayUse::kAlways && !any_may_stand_between(world->polygons_, tolerance)) return world;
  world->index_.emplace(world->polygons_);
  world->rays_.emplace(world->polygons_);
  return world;
}

std::size_t RayWorld::bytes() const {
  return set_.items.size() * sizeof(BlockerSet::Item) + set_.vertices.size() * sizeof(Vec3) +
         polygons_.size() * sizeof(BlockerPolygon) +
         (index_ ? index_->bytes() + rays_->bytes() : 0);
}

Rows<ClusterId> seen_from_rooms(const Model& model) {
  std::vector<std::vector<ClusterId>> seen(model.rooms);
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    std::vector<ClusterId>& row = seen[model.clusters[c].room];
    const std::span<const ClusterId> visible = model.visible[c];
    row.push_back(ClusterId(c));
    row.insert(row.end(), visible.begin(), visible.end());
  }
  Rows<ClusterId> rows;
  for (std::vector<ClusterId>& row : seen) {
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    rows.push_row(row);
  }
  return rows;
}

std::uint32_t count_rooms_without_rays(const Model& model) {
  const Rows<ClusterId> seen = seen_from_rooms(model);
  std::uint32_t count = 0;
  std::vector<BlockerPolygon> polygons;
  for (std::size_t room = 0; room < seen.size(); ++room) {
    polygons.clear();
    for (const ClusterId c : seen[room]) {
      const Cluster& cluster = model.clusters[c.value];
      for (std::uint32_t p = 0; p < cluster.patch_count; ++p)
        polygons.push_back({model.polygon(model.patches[cluster.first_patch + p]), p});
    }
    count += !polygons.empty() && !any_may_stand_between(polygons, model.tolerance);
  }
  return count;
}

RayWorlds::RayWorlds(const Model& model, ClusterStore& store, RayUse use, std::size_t budget)
    : model_(model),
      store_(store),
      use_(use),
      budget_(budget),
      seen_from_room_(seen_from_rooms(model)) {}

Result<const RayWorld*> RayWorlds::of(ClusterId receiver) {
  const std::uint32_t room = model_.clusters[receiver.value].room;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    if (kept_[i].room == room) {
      std::rotate(kept_.begin(), kept_.begin() + i, kept_.begin() + i + 1);
      return static_cast<const RayWorld*>(kept_[0].world.get());
    }
  if (kept_.size() == kKept) kept_.pop_back();
  Result<std::unique_ptr<RayWorld>> world =
      RayWorld::build(store_, seen_from_room_[room], model_.tolerance, use_);
  if (!world.ok()) return world.status();
  kept_.insert(kept_.begin(), {room, std::move(world).value()});
  while (kept_.size() > 1 && bytes() > budget_) kept_.pop_back();
  return static_cast<const RayWorld*>(kept_[0].world.get());
}

std::size_t RayWorlds::bytes() const {
  std::size_t sum = 0;
  for (const Entry& e : kept_) sum += e.world->bytes();
  return sum;
}

}  // namespace atrium
