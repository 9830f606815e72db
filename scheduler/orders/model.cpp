// "Model order gathers to clusters in the order in which they were instantiated by the modeler."
// [THFH94 §6]
#include "scheduler/orders/orders.h"

namespace atrium {

Sequence model_order(const OrderTask& task) {
  Sequence s;
  for (std::size_t c = 0; c < task.model.clusters.size(); ++c) s.push_back(ClusterId(c));
  return s;
}

}  // namespace atrium
