// "Random order gathers to clusters in random order." [THFH94 §6]
#include <utility>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

std::uint64_t split_mix(std::uint64_t& state) {  // [Steele, Lea, Flood 2014]
  std::uint64_t z = state += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

}  // namespace

Sequence random_order(const OrderTask& task) {
  Sequence s = model_order(task);
  std::uint64_t state = task.seed;
  for (std::size_t i = s.size(); i > 1; --i) std::swap(s[i - 1], s[split_mix(state) % i]);
  return s;
}

}  // namespace atrium
