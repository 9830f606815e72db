#include "scheduler/run_state.h"

#include <algorithm>
#include <cstring>
#include <type_traits>

namespace atrium {

static_assert(std::is_trivially_copyable_v<RunState>);

void WorkingSetCourse::add(std::uint64_t gathered, std::uint64_t all, std::uint64_t bytes) {
  const std::size_t step = gathered * std::min<std::uint64_t>(kMostSteps, all) / all;
  largest[step] = std::max(largest[step], bytes);
  sum[step] += bytes;
  ++gathers[step];
}

void Sweep::add(const GatherReport& r, std::uint64_t clusters) {
  working_sets.add(gathered, clusters, r.working_set_bytes);
  sums.add(r.sums);
  refined.add(r.refined);
  ++gathered;
  elements += r.elements;
  links += r.links;
  working_set_bytes = std::max(working_set_bytes, r.working_set_bytes);
  working_set_links = std::max(working_set_links, r.links);
  working_set_elements = std::max(working_set_elements, r.working_set_elements);
  total_bytes += r.link_bytes + r.source_elements * sizeof(Element);
  solver_seconds += r.solver_seconds;
}

std::span<const std::byte> to_bytes(const RunState& state) {
  return std::as_bytes(std::span(&state, 1));
}

Result<RunState> run_state(std::span<const std::byte> bytes, const std::string& directory) {
  RunState state;
  if (bytes.size() == sizeof state) {
    std::memcpy(&state, bytes.data(), sizeof state);
    if (state.version == kRunStateVersion) return state;
  }
  return Status(Code::kStore, directory, "state", "it is not of this version of atrium",
                "solve the scene again, into another directory");
}

}  // namespace atrium
