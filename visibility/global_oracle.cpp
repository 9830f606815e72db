#include "visibility/global_oracle.h"

#include "visibility/facing.h"

namespace atrium {

Rows<ClusterId> find_visible(const Bsp& bsp, const std::vector<CellPortal>& portals,
                             const Model& model, const std::vector<ClusterInCell>& places) {
  // Space that portals join is one region; lit cells of different regions never see each other.
  std::vector<std::uint32_t> region(bsp.cells.size(), ~0u);
  for (std::uint32_t c = 0; c < bsp.cells.size(); ++c) {
    if (region[c] != ~0u) continue;
    const std::vector<bool> reached = flood(bsp.cells.size(), portals, {c});
    for (std::uint32_t d = 0; d < bsp.cells.size(); ++d)
      if (reached[d]) region[d] = c;
  }
  std::vector<std::uint32_t> of_cluster(model.clusters.size());
  for (const ClusterInCell& place : places) of_cluster[place.cluster] = region[place.cell];
  const Facing facing(model);
  Rows<ClusterId> visible;
  std::vector<ClusterId> row;
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c) {
    row.clear();
    for (std::uint32_t d = 0; d < model.clusters.size(); ++d)
      if (of_cluster[c] == of_cluster[d] && facing.may_see(c, d)) row.push_back(ClusterId(d));
    visible.push_row(row);
  }
  return visible;
}

}  // namespace atrium
