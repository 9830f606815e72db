#include "visibility/portal.h"

#include <map>

#include "engine/disjoint_sets.h"

namespace atrium {

namespace {

// A cell's face is open if more than this share of it is.
constexpr double kOpenFace = 0.5;

}  // namespace

void find_portals(const Bsp& bsp, std::size_t i, std::vector<CellPortal>& portals) {
  const BspNode& node = bsp.nodes[i];
  const double sliver = kSliverTolerances * bsp.tolerance;
  std::vector<CellPiece> front, back;
  drop_polygon(bsp, node.front, node.section, node.plane.normal, front);
  for (const CellPiece& f : front) {
    back.clear();
    drop_polygon(bsp, node.back, f.polygon, -node.plane.normal, back);
    for (const CellPiece& b : back)
      for (OpenPiece& open : open_pieces(node.opaque, b.polygon, sliver))
        portals.push_back(
            {static_cast<std::uint32_t>(i), f.cell, b.cell, std::move(open.polygon), open.area});
  }
}

std::vector<CellPortal> find_portals(const Bsp& bsp) {
  std::vector<CellPortal> portals;
  for (std::size_t i = 0; i < bsp.nodes.size(); ++i) find_portals(bsp, i, portals);
  return portals;
}

std::vector<bool> flood(std::size_t cells, const std::vector<CellPortal>& portals,
                        const std::vector<std::uint32_t>& sources) {
  const Rows32 beside = cells_beside(cells, portals, [](std::size_t) { return true; });
  std::vector<bool> reached(cells, false);
  std::vector<std::uint32_t> open;
  auto reach = [&](std::uint32_t cell) {
    if (reached[cell]) return;
    reached[cell] = true;
    open.push_back(cell);
  };
  for (std::uint32_t cell : sources) reach(cell);
  while (!open.empty()) {
    const std::uint32_t cell = open.back();
    open.pop_back();
    for (std::uint32_t next : beside[cell]) reach(next);
  }
  return reached;
}

Rooms find_rooms(const Bsp& bsp, const std::vector<CellPortal>& portals,
                 const std::vector<bool>& lit) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> open;  // m², by cell and node
  for (const CellPortal& p : portals) {
    open[{p.front, p.node}] += p.area;
    open[{p.back, p.node}] += p.area;
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> whole;
  for (std::uint32_t c = 0; c < bsp.cells.size(); ++c)
    for (const CellFace& face : bsp.cells[c].faces) whole[{c, face.node}] += area(face.polygon);
  auto is_open = [&](std::uint32_t cell, std::uint32_t node) {
    return open[{cell, node}] > kOpenFace * whole[{cell, node}];
  };

  DisjointSets joined(bsp.cells.size());
  for (const CellPortal& p : portals)
    if (lit[p.front] && lit[p.back] && is_open(p.front, p.node) && is_open(p.back, p.node))
      joined.join(p.front, p.back);

  Rooms rooms;
  rooms.of_cell.assign(bsp.cells.size(), kNoRoom);
  std::vector<std::uint32_t> number(bsp.cells.size(), kNoRoom);
  for (std::uint32_t c = 0; c < bsp.cells.size(); ++c) {
    if (!lit[c]) continue;
    std::uint32_t& n = number[joined.find(c)];
    if (n == kNoRoom) n = rooms.count++;
    rooms.of_cell[c] = n;
  }
  return rooms;
}

}  // namespace atrium
