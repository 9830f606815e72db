// The orders by name, one a file: [THFH94 §6] has the first four and names most of the others as
// its authors' next steps. Pure functions; each returns a permutation of the model's clusters, the
// same for the same task.
#pragma once

#include <vector>

#include "scheduler/order.h"

namespace atrium {

using Sequence = std::vector<ClusterId>;

Sequence random_order(const OrderTask& task);
Sequence model_order(const OrderTask& task);
Sequence source_order(const OrderTask& task);
Sequence cell_order(const OrderTask& task);
Sequence nearest_order(const OrderTask& task);
Sequence tree_order(const OrderTask& task);
Sequence tour_order(const OrderTask& task);
Sequence hilbert_order(const OrderTask& task);
Sequence bright_order(const OrderTask& task);

}  // namespace atrium
