// Portals: where two cells join through what a splitting plane leaves open. And what follows from
// them: the cells that light can reach, and the rooms, groups of cells that are one space.
// Pure functions over a finished subdivision; safe from any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "visibility/bsp.h"

namespace atrium {

struct CellPortal {
  std::uint32_t node = 0;   // in whose plane it lies
  std::uint32_t front = 0;  // cell on the plane's front
  std::uint32_t back = 0;   // and on its back
  Polygon polygon;          // convex, counter-clockwise about the plane's normal
  double area = 0;          // m², transparent
  std::uint32_t across(std::uint32_t cell) const { return cell == front ? back : front; }
};

using Rows32 = std::vector<std::vector<std::uint32_t>>;  // of cells, or of portals

// Adds those in one node's plane, in the order of cells.
void find_portals(const Bsp& bsp, std::size_t node, std::vector<CellPortal>& portals);

// In the order of nodes, then of cells.
std::vector<CellPortal> find_portals(const Bsp& bsp);

// A row a cell: those that portals join it to, in the portals' order; only the portals that `keep`,
// given their number, says yes to.
template <class Keep>
Rows32 cells_beside(std::size_t cells, const std::vector<CellPortal>& portals, Keep&& keep) {
  Rows32 rows(cells);
  for (std::size_t i = 0; i < portals.size(); ++i) {
    if (!keep(i)) continue;
    rows[portals[i].front].push_back(portals[i].back);
    rows[portals[i].back].push_back(portals[i].front);
  }
  return rows;
}

// Cells from which light that enters at `sources` can be seen, by portals alone.
std::vector<bool> flood(std::size_t cells, const std::vector<CellPortal>& portals,
                        const std::vector<std::uint32_t>& sources);

// A room for each lit cell, numbered in the cells' order. Two cells are one room where the plane
// between them is mostly open on both: planes that merely run on through a room's air join it,
// doorways do not. Dark cells get kNoRoom.
inline constexpr std::uint32_t kNoRoom = ~0u;
struct Rooms {
  std::vector<std::uint32_t> of_cell;
  std::uint32_t count = 0;
};
Rooms find_rooms(const Bsp& bsp, const std::vector<CellPortal>& portals,
                 const std::vector<bool>& lit);

}  // namespace atrium
