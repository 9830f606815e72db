// Cell to cluster: which clusters can be seen from a cell, through sequences of portals, and from
// what one cell has of a cluster. [THFH94 §5]
//
// Invariants:
//  1. Conservative: a cluster that any point of the source sees is in its row.
//  2. Rows are sorted, and do not depend on the number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry.h"
#include "visibility/portal_flow.h"

namespace atrium {

// What of a cluster one cell has: a box along the subdivision's frame.
struct ClusterInCell {
  std::uint32_t cluster = 0, cell = 0;
  Box box;  // in coordinates of the frame
};

// About how many windows flows from all portals will look at: from a few of them, evenly taken.
double expected_steps(const PortalGraph& graph);

class CellVisibility {
 public:
  using ClusterRow = std::vector<std::uint32_t>;

  CellVisibility(const PortalGraph& graph, const Frame& frame, std::vector<ClusterInCell> places,
                 std::size_t clusters);

  // A row a cell: the clusters seen from anywhere in it, its own included.
  std::vector<ClusterRow> from_cells() const;

  // A row a cluster: what is seen from its boxes, within `allowed`, its row of clusters that may
  // be at all.
  std::vector<ClusterRow> from_clusters(const std::vector<ClusterRow>& allowed) const;

 private:
  struct Worker;
  bool seen(const ClusterInCell& place, std::span<const Plane> planes) const;
  void collect_cell(std::uint32_t cell, Worker& worker) const;
  void collect_flow(Worker& worker) const;

  const PortalGraph& graph_;
  Frame frame_;
  std::vector<ClusterInCell> places_;
  std::vector<std::vector<std::uint32_t>> places_in_;  // by cell
  std::size_t clusters_;
};

}  // namespace atrium
