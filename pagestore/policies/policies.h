// The makers of the policies in table.inc; capacity in bytes of the arena.
#pragma once

#include <cstdint>
#include <memory>

#include "pagestore/policy.h"

namespace atrium {

#define ATRIUM_POLICY(NAME, MAKER, FORESIGHT) std::unique_ptr<Policy> MAKER(std::uint64_t capacity);
#include "pagestore/policies/table.inc"
#undef ATRIUM_POLICY

}  // namespace atrium
