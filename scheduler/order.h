// Gather orders: in which sequence the clusters of one iteration are gathered to, each completely.
// [THFH94 §6] The sequence is known ahead. Adding one: a function here, a line in the table of
// order.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/status.h"

namespace atrium {

std::vector<std::string> order_names();

// A permutation of all clusters. Errors: kUsage, unknown name.
Result<std::vector<ClusterId>> make_order(const std::string& name, const Model& model,
                                          std::uint64_t seed);

}  // namespace atrium
