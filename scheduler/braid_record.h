// Braid record: all braids of one receiver as bytes for the page store, so that links outlive the
// memory they do not fit into, and the process. Little endian, as in memory:
//
//     braids, then for each: source, and how many strands, links, couplings, thin links, doubts,
//     verdicts (4 bytes each); then those arrays, one after the other.
// Pure functions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "engine/status.h"
#include "solver/link.h"

namespace atrium {

std::vector<std::byte> write_braids(std::span<const Braid> braids);
// kStore: the record is shorter or longer than what it says it holds.
Result<std::vector<Braid>> read_braids(std::span<const std::byte> record);

std::uint64_t bytes_of(std::span<const Braid> braids);  // of memory

}  // namespace atrium
