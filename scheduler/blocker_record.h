// The record of a cluster's blockers: the polygons of its patches, in space, which is all that a
// gather needs of a cluster that merely stands in the way. Written once, never changed.
//
//   u32 polygons, u32 vertices | per polygon: u32 patch, u32 vertex count | per vertex: 3 doubles
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/model.h"
#include "engine/status.h"

namespace atrium {

std::vector<std::byte> write_blockers(const Model& model, const Cluster& cluster);

// Polygons of several clusters side by side, owning their vertices.
struct BlockerSet {
  struct Item {
    std::uint32_t patch, first_vertex, vertex_count;
  };
  std::vector<Item> items;
  std::vector<Vec3> vertices;
  PolygonView polygon(const Item& i) const {
    return std::span(vertices).subspan(i.first_vertex, i.vertex_count);
  }
};

Status append_blockers(std::span<const std::byte> record, BlockerSet& set);

}  // namespace atrium
