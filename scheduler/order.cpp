#include "scheduler/order.h"

#include <algorithm>
#include <array>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

struct Named {
  const char* name;
  Sequence (*make)(const OrderTask&);
};
constexpr std::array<Named, 9> kOrders{{{"random", random_order},
                                        {"model", model_order},
                                        {"source", source_order},
                                        {"cell", cell_order},
                                        {"nearest", nearest_order},
                                        {"tree", tree_order},
                                        {"tour", tour_order},
                                        {"hilbert", hilbert_order},
                                        {"bright", bright_order}}};

const Named* find_order(const std::string& name) {
  const auto found = std::ranges::find(kOrders, name, &Named::name);
  return found == kOrders.end() ? nullptr : &*found;
}

}  // namespace

std::vector<std::string> order_names() {
  std::vector<std::string> names;
  for (const Named& o : kOrders) names.push_back(o.name);
  return names;
}

Status check_order(const std::string& name) {
  if (find_order(name)) return {};
  std::string known;
  for (const Named& o : kOrders) known += std::string(known.empty() ? "" : ", ") + o.name;
  return Status(Code::kUsage, "", "--order " + name, "unknown order", "use one of: " + known);
}

Result<std::vector<ClusterId>> make_order(const std::string& name, const OrderTask& task) {
  ATRIUM_RETURN_IF_ERROR(check_order(name));
  return find_order(name)->make(task);
}

}  // namespace atrium
