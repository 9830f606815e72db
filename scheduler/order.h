// Gather orders: in which sequence the clusters of one iteration are gathered to, each completely.
// [THFH94 §6] The sequence is known ahead, and repeated by every iteration. An order is a function
// in a file of orders/ and a line in the table of order.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"
#include "engine/status.h"

namespace atrium {

// What an order may look at: nothing that a gather changes, nor arena or threads, so that a run is
// the same for any of these.
struct OrderTask {
  const Model& model;
  std::span<const Material> materials;  // of the model's patches
  std::uint64_t seed = 1;
};

std::vector<std::string> order_names();

// Errors: kUsage, unknown name.
Status check_order(const std::string& name);
// A permutation of all clusters. Errors: likewise.
Result<std::vector<ClusterId>> make_order(const std::string& name, const OrderTask& task);

}  // namespace atrium
