// Leaks: cracks that join two rooms, or a room and the outdoors, through a wall's inside or
// straight through it. What an architect needs to mend a model.
//
// A room is space to stand in: no wall's inside, no gap behind a cupboard. Rooms end at doorways.
// What lies between rooms is a passage (a doorway's depth, the space under a desk) where a ball of
// the leak's size gets there from a room, else a void. A leak leads from a room or its passages
// through narrow openings and voids to another; a void may join many rooms, and then each leak
// told is the widest way that is left between two of them, and its size that of its narrowest
// opening.
//
// Invariants:
//  1. Independent of lamps: a model can be mended before it has any.
//  2. Widest first; the same for a turned or shifted scene, up to rounding.
// Pure functions; safe from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/scene.h"
#include "visibility/bsp.h"
#include "visibility/portal.h"

namespace atrium {

// Neither room nor outdoors; the space around the scene.
inline constexpr std::uint32_t kNoSpace = ~0u, kOutdoors = ~0u - 1;

// The subdivision that leaks are looked for in, and what of it is a room. It is as fine as the
// planes of a partition ever are: no sight is searched in it.
struct RoomPlan {
  Bsp bsp;
  std::vector<CellPortal> portals;           // between all cells, dark ones too
  Rows32 groups;                             // of portals: openings
  std::vector<std::uint32_t> space_of_cell;  // a room's number, kOutdoors or kNoSpace
  std::uint32_t rooms = 0;
};
RoomPlan find_room_plan(const Scene& scene);

struct Leak {
  double width = 0, length = 0;         // m, of its narrowest opening
  std::array<std::uint32_t, 2> spaces;  // rooms' numbers, the outdoors last
  std::vector<ObjectId> objects;        // around that opening: most of its rim first
  Vec3 at{0};                           // where it is widest
  Vec3 along{0};                        // unit, the direction in which it is long
};

// Openings narrower than `size` metres.
std::vector<Leak> find_leaks(const Scene& scene, const RoomPlan& plan, double size);

}  // namespace atrium
