#include "visibility/gap.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace atrium {

namespace {

// A row a cell: those that portals wider than `size` join it to, sorted. Narrower ones may be gaps.
Rows32 neighbours(std::size_t cells, const std::vector<CellPortal>& portals, double size) {
  Rows32 rows = cells_beside(cells, portals,
                             [&](std::size_t i) { return strip_width(portals[i].polygon) > size; });
  for (auto& row : rows) {
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
  }
  return rows;
}

// The cut of the polygon's plane through the cell.
Polygon section_of(const Bsp& bsp, std::uint32_t cell, PolygonView polygon) {
  const std::vector<CellFace>& faces = bsp.cells[cell].faces;
  Box box;
  for (const CellFace& face : faces) box.extend(bounds(face.polygon));
  const Frame f = frame_of(polygon);
  const Vec3 middle = box.center() - dot(box.center() - f.origin, f.n) * f.n;
  return section(faces, middle, box.diagonal() * f.u, box.diagonal() * f.v, bsp.tolerance);
}

// A plane that splits the space between two others ends where they do, and its portal there is a
// strip; but where they are open beside it one cell lies on both sides of the strip's edge, and the
// opening goes on in that cell: such a strip is no gap.
class Beyond {
 public:
  Beyond(const Bsp& bsp, const std::vector<CellPortal>& portals, double size)
      : bsp_(bsp),
        size_(size),
        joints_(portals),
        beside_(neighbours(bsp.cells.size(), portals, size)) {}

  bool goes_on(const CellPortal& strip) const {
    const auto& other = beside_[strip.back];
    return std::ranges::any_of(beside_[strip.front], [&](std::uint32_t cell) {
      return std::ranges::binary_search(other, cell) && goes_on_in(cell, strip);
    });
  }

 private:
  bool goes_on_in(std::uint32_t cell, const CellPortal& strip) const {
    Polygon cut = section_of(bsp_, cell, strip.polygon);
    if (cut.empty() || strip_width(cut) <= size_) return false;
    return one_opening(strip, {strip.node, cell, cell, std::move(cut), 0}, joints_,
                       kSliverTolerances * bsp_.tolerance);
  }

  const Bsp& bsp_;
  const double size_;
  const Joints joints_;
  const Rows32 beside_;
};

// The opening's portals that nothing of the size passes.
std::vector<std::uint32_t> closed_by(const NarrowOpening& opening, const std::vector<bool>& wide,
                                     const std::vector<CellPortal>& portals, const Beyond& beyond) {
  std::vector<std::uint32_t> closed;
  for (const std::uint32_t i : opening.portals)
    if (!wide[i] && !beyond.goes_on(portals[i])) closed.push_back(i);
  return closed;
}

void take_out(const std::vector<bool>& gone, std::vector<CellPortal>& portals) {
  std::vector<CellPortal> left;
  left.reserve(portals.size());
  for (std::size_t i = 0; i < portals.size(); ++i)
    if (!gone[i]) left.push_back(std::move(portals[i]));
  portals = std::move(left);
}

}  // namespace

std::vector<Gap> close_gaps(const Bsp& bsp, double size, std::vector<CellPortal>& portals) {
  std::vector<Gap> gaps;
  if (!(size > 0)) return gaps;
  const Beyond beyond(bsp, portals, size);
  Openings openings = find_openings(bsp, portals, group_portals(bsp, portals), size);
  std::vector<bool> gone(portals.size(), false);
  for (NarrowOpening& opening : openings.narrow) {
    const std::vector<std::uint32_t> closed = closed_by(opening, openings.wide, portals, beyond);
    if (closed.empty()) continue;
    Gap gap{std::move(opening), {}};
    for (const std::uint32_t i : closed) {
      gap.portals.push_back(portals[i]);
      gone[i] = true;
    }
    gaps.push_back(std::move(gap));
  }
  take_out(gone, portals);
  return gaps;
}

std::vector<ClosedGap> gaps_of_light(const Scene& scene, const BoxTree& tree,
                                     const std::vector<Gap>& gaps, const std::vector<bool>& lit) {
  std::vector<ClosedGap> out;
  for (const Gap& gap : gaps) {
    if (std::ranges::none_of(gap.portals,
                             [&](const CellPortal& p) { return lit[p.front] || lit[p.back]; }))
      continue;
    ClosedGap closed{gap.opening.width,
                     gap.opening.length,
                     gap.opening.widest,
                     objects_around(scene, tree, gap.opening),
                     {}};
    for (const CellPortal& p : gap.portals) closed.polygons.push_back(p.polygon);
    out.push_back(std::move(closed));
  }
  std::ranges::stable_sort(out, std::greater{}, &ClosedGap::width);
  return out;
}

}  // namespace atrium
