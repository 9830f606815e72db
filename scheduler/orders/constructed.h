// Orders made from gather sets that are there already: the tour starts from them.
#pragma once

#include "scheduler/orders/gather_sets.h"

namespace atrium {

Sequence by_nearest(const GatherSets& gathers);
Sequence by_tree(const GatherSets& gathers);

}  // namespace atrium
