#include "solver/refine_counters.h"

namespace atrium {

void RefineCounters::add(const RefineCounters& c) {
  links += c.links;
  thin_links += c.thin_links;
  rays += c.rays;
  packets += c.packets;
  kernels += c.kernels;
  splits += c.splits;
  tubes_visible += c.tubes_visible;
  tubes_invisible += c.tubes_invisible;
  tubes_partial += c.tubes_partial;
  thin_pairs += c.thin_pairs;
  thin_rays += c.thin_rays;
  links_without_rays += c.links_without_rays;
}

}  // namespace atrium
