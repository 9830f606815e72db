// The walk through the cells that cell order takes [THFH94 §6], and what is gathered to on the way.
#pragma once

#include <span>
#include <vector>

#include "scheduler/orders/gather_sets.h"

namespace atrium {

// Lit cells, in the order in which the walk first enters them and in that in which it leaves them
// for good.
struct CellWalk {
  std::vector<CellId> entered, left;
};
CellWalk walk_cells(const Model& model);

// All clusters, each with the first of these cells that it borders.
Sequence cell_by_cell(const Model& model, const GatherSets& gathers,
                      std::span<const CellId> cells);

}  // namespace atrium
