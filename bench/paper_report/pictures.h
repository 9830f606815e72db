// The paper's Figures 4, 5 and 6 as SVG.
// Functions of their arguments.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "apps/report/interaction_matrix.h"
#include "bench/paper_report/figures.h"
#include "engine/status.h"

namespace atrium {

// Figure 4: working sets while one iteration solves the model. `iteration` tells of them.
std::string working_set_picture(const std::string& model, const HistoryEntry& iteration);

struct OrderedMatrix {
  std::string order;
  InteractionMatrix matrix;
};
// Figure 5: a panel an order, A), B) and so on.
Result<std::string> matrices_picture(const std::vector<OrderedMatrix>& matrices);

// Figure 6: of each order's time the share of I/O, the paper's over ours.
std::string time_picture(std::span<const OrderFigures> ours);
Figure io_share(const OrderFigures& order);

}  // namespace atrium
