// The interaction matrix [THFH94 §6, figure 5]: position (i, j) is marked if the cluster that is
// gathered to i-th may see the one that is j-th. A good order has its marks in blocks along the
// diagonal: what a gather reads, the next one reads again. Of bounded size, whatever the scene: a
// cell stands for as many clusters a side as it must, and is the darker the more of its pairs may
// see each other.
// Plain data and functions of it; no state.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "apps/picture/image.h"
#include "engine/model.h"

namespace atrium {

inline constexpr std::size_t kMostMatrixCells = 300;  // a side

struct InteractionMatrix {
  std::size_t clusters = 0;
  std::size_t pairs = 0;      // that may see each other, both ways, self-pairs included
  double common = 0;          // share of what a gather may see, that the one before it may see too
  std::size_t side = 0;       // cells
  std::vector<double> share;  // of each cell's pairs: side × side, the first receivers' row first
};

// `order`: a permutation of the clusters that `visible` has a row of each. At least one cluster.
InteractionMatrix interaction_matrix(const Rows<ClusterId>& visible,
                                     std::span<const ClusterId> order,
                                     std::size_t most_cells = kMostMatrixCells);

// A pixel a cell, dark on white; the first pair at the lower left, as in the paper.
Image matrix_image(const InteractionMatrix& matrix);

}  // namespace atrium
