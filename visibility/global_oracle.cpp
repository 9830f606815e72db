#include "visibility/global_oracle.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>

#include "visibility/facing.h"

namespace atrium {

namespace {

using ClusterRow = CellVisibility::ClusterRow;

// Keeps j in row i only where i is in row j too: sight goes both ways.
std::vector<ClusterRow> both_ways(const std::vector<ClusterRow>& rows) {
  std::vector<ClusterRow> out(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
    std::copy_if(rows[i].begin(), rows[i].end(), std::back_inserter(out[i]), [&](std::uint32_t j) {
      return std::binary_search(rows[j].begin(), rows[j].end(), static_cast<std::uint32_t>(i));
    });
  });
  return out;
}

// A cluster sees what its cells see.
std::vector<ClusterRow> by_cells(const std::vector<ClusterRow>& from_cells, const Model& model) {
  std::vector<ClusterRow> rows(model.clusters.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t c) {
    ClusterRow& row = rows[c];
    for (CellId cell : model.cells_of_cluster[c])
      row.insert(row.end(), from_cells[cell.value].begin(), from_cells[cell.value].end());
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
  });
  return rows;
}

std::vector<ClusterRow> those_facing(const std::vector<ClusterRow>& rows, const Model& model) {
  const Facing facing(model);
  // The lower of two decides for both.
  std::vector<ClusterRow> later(rows.size()), out(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t i) {
    const auto self = static_cast<std::uint32_t>(i);
    std::copy_if(rows[i].begin(), rows[i].end(), std::back_inserter(later[i]),
                 [&](std::uint32_t j) { return j >= self && facing.may_see(self, j); });
  });
  for (std::uint32_t i = 0; i < rows.size(); ++i)
    for (std::uint32_t j : later[i]) {
      out[i].push_back(j);
      if (j != i) out[j].push_back(i);
    }
  for (ClusterRow& row : out) std::sort(row.begin(), row.end());
  return out;
}

}  // namespace

Rows<ClusterId> find_visible(const Bsp& bsp, const std::vector<CellPortal>& lit_portals,
                             const Model& model, std::vector<ClusterInCell> places) {
  const PortalGraph graph = make_graph(bsp, lit_portals);
  const CellVisibility sight(graph, bsp.frame, std::move(places), model.clusters.size());
  std::vector<ClusterRow> rows = both_ways(by_cells(sight.from_cells(), model));
  rows = those_facing(rows, model);
  rows = both_ways(sight.from_clusters(rows));
  Rows<ClusterId> visible;
  for (const ClusterRow& row : rows) {
    std::vector<ClusterId> ids;
    for (std::uint32_t j : row) ids.push_back(ClusterId(j));
    visible.push_row(ids);
  }
  return visible;
}

}  // namespace atrium
