#include "scheduler/working_set.h"

#include <algorithm>

namespace atrium {

namespace {

std::vector<BlockerPolygon> polygons_of(const Model& model, std::span<const ClusterId> clusters) {
  std::vector<BlockerPolygon> polygons;
  for (const ClusterId id : clusters) {
    const Cluster& cluster = model.clusters[id.value];
    for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p)
      polygons.push_back({model.polygon(model.patches[p]), p});
  }
  return polygons;
}

}  // namespace

RayWorld::RayWorld(const Model& model, std::span<const ClusterId> clusters, RayUse use)
    : polygons_(polygons_of(model, clusters)) {
  if (use != RayUse::kAlways && !any_may_stand_between(polygons_, model.tolerance)) return;
  index_.emplace(polygons_);
  rays_.emplace(polygons_);
}

std::size_t RayWorld::bytes() const {
  std::size_t vertices = 0;
  for (const BlockerPolygon& b : polygons_) vertices += b.polygon.size();
  return vertices * sizeof(Vec3) + polygons_.size() * sizeof(BlockerPolygon) +
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
  for (std::size_t room = 0; room < seen.size(); ++room) {
    const std::vector<BlockerPolygon> polygons = polygons_of(model, seen[room]);
    count += !polygons.empty() && !any_may_stand_between(polygons, model.tolerance);
  }
  return count;
}

RayWorlds::RayWorlds(const Model& model, RayUse use, std::size_t budget)
    : model_(model), use_(use), budget_(budget), seen_from_room_(seen_from_rooms(model)) {}

const RayWorld& RayWorlds::of(ClusterId receiver) {
  const std::uint32_t room = model_.clusters[receiver.value].room;
  for (std::size_t i = 0; i < kept_.size(); ++i)
    if (kept_[i].room == room) {
      std::rotate(kept_.begin(), kept_.begin() + i, kept_.begin() + i + 1);
      return *kept_[0].world;
    }
  if (kept_.size() == kKept) kept_.pop_back();
  auto world = std::make_unique<RayWorld>(model_, seen_from_room_[room], use_);
  kept_.insert(kept_.begin(), {room, std::move(world)});
  while (kept_.size() > 1 && bytes() > budget_) kept_.pop_back();
  return *kept_[0].world;
}

std::size_t RayWorlds::bytes() const {
  std::size_t sum = 0;
  for (const Entry& e : kept_) sum += e.world->bytes();
  return sum;
}

}  // namespace atrium
