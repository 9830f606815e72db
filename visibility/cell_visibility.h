// Cluster to cluster: what can be seen from what each cell has of a cluster, through sequences of
// portals. [THFH94 §5; Teller 92]
//
// Invariants:
//  1. Conservative: two clusters of which any two points see each other are a pair.
//  2. Pairs are sorted, and do not depend on the number of threads.
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

// A row a cluster, sorted: itself and clusters after it. A pair stands in the row of its first.
using PairRows = std::vector<std::vector<std::uint32_t>>;

class CellVisibility {
 public:
  CellVisibility(const PortalGraph& graph, const Frame& frame, std::vector<ClusterInCell> places,
                 std::size_t clusters);

  // The pairs of which either sees the other's boxes from its own.
  PairRows seen_pairs() const;

  // Leaves the partners of a cluster such that sight spreads between a place of the one and a place
  // of the other within the shaft of both.
  class PairJudge {
   public:
    explicit PairJudge(const CellVisibility& sight) : sight_(sight), flow_(sight.graph_) {}
    void keep_joined(std::uint32_t c, std::vector<std::uint32_t>& partners);

   private:
    bool joined(std::uint32_t c, std::uint32_t d);
    bool joined(const ClusterInCell& a, const ClusterInCell& b);
    const CellVisibility& sight_;
    PortalFlow flow_;
    std::size_t steps_left_ = 0;
  };

 private:
  struct Worker;
  bool seen(const ClusterInCell& place, std::span<const Plane> planes) const;
  void collect(std::uint32_t cluster, Worker& worker) const;
  std::vector<Plane> shaft_of(const Box& a, const Box& b) const;

  const PortalGraph& graph_;
  Frame frame_;
  std::vector<ClusterInCell> places_;
  std::vector<std::vector<std::uint32_t>> places_in_;  // by cell
  std::vector<std::vector<std::uint32_t>> places_of_;  // by cluster
};

}  // namespace atrium
