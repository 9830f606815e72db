// RefineCounters: what refinement did, for the history, the summary and whoever judges it. Plain
// numbers that are part of a checkpoint's state.
#pragma once

#include <cstdint>

namespace atrium {

// Rays are segments tested against what may stand between. Kernels are pairs looked at closely: as
// many tubes, where something may stand between, less the few that turn away from each other.
struct RefineCounters {
  std::uint64_t links = 0, thin_links = 0, rays = 0, packets = 0, kernels = 0, splits = 0;
  std::uint64_t tubes_visible = 0, tubes_invisible = 0, tubes_partial = 0;
  std::uint64_t thin_pairs = 0;          // thin links, those that something blocks included
  std::uint64_t thin_rays = 0;           // of the rays, for them
  std::uint64_t links_without_rays = 0;  // of the links, thin ones not included
  void add(const RefineCounters& c);
};

}  // namespace atrium
