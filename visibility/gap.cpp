#include "visibility/gap.h"

#include <algorithm>
#include <functional>

namespace atrium {

namespace {

// The opening's portals that nothing of the size passes.
std::vector<std::uint32_t> closed_by(const NarrowOpening& opening, const std::vector<bool>& wide) {
  std::vector<std::uint32_t> closed;
  for (const std::uint32_t i : opening.portals)
    if (!wide[i]) closed.push_back(i);
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
  Openings openings = find_openings(bsp, portals, group_portals(bsp, portals), size);
  std::vector<bool> gone(portals.size(), false);
  for (NarrowOpening& opening : openings.narrow) {
    const std::vector<std::uint32_t> closed = closed_by(opening, openings.wide);
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
