// Blockers: the convex polygons that can stand between the entities of a working set, and the
// bounding-volume index that finds those reaching into a shaft. "Only entities that impinge upon
// the shaft may be blockers." [THFH94 §4]
//
// Invariants:
//  1. Lists of blockers hold positions in the span that the index was built on, never addresses.
//  2. collect() is conservative as may_block() is, and its order depends on the span alone.
// The span and its vertices are the caller's and outlive the index. Immutable once built; any
// number of threads may query.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

struct Shaft;

struct BlockerPolygon {
  PolygonView polygon;   // convex
  std::uint32_t id = 0;  // the caller's name for it
};

// Can any of them stand between two points of them? Not where each has all the others on one side,
// as the walls of a convex empty room have.
bool any_may_stand_between(std::span<const BlockerPolygon> polygons, double tolerance);

class BlockerIndex {
 public:
  BlockerIndex() = default;
  explicit BlockerIndex(std::span<const BlockerPolygon> blockers);

  std::span<const BlockerPolygon> blockers() const { return blockers_; }

  // Writes the positions of the blockers that reach into the shaft to the front of `out` and
  // returns how many; nothing if `out` is too short, and then `out` holds the first of them.
  std::optional<std::size_t> collect(const Shaft& shaft, std::span<std::uint32_t> out) const;

  std::size_t bytes() const;

 private:
  struct Item {
    Box box;
    std::uint32_t position;  // in blockers_
  };
  struct Node {
    Box box;
    std::uint32_t first;  // leaf: its first item; else its second child (the first comes next)
    std::uint32_t count;  // leaf: its items; else 0
  };
  void build(std::uint32_t first, std::uint32_t count);

  std::span<const BlockerPolygon> blockers_;
  std::vector<Item> items_;
  std::vector<Node> nodes_;  // depth first
};

}  // namespace atrium
