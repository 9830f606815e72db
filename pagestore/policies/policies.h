// The makers of the policies in table.inc; capacity in bytes of the arena.
#pragma once

#include <cstddef>
#include <memory>

#include "pagestore/policy.h"

namespace atrium {

#define ATRIUM_POLICY(NAME) std::unique_ptr<Policy> make_##NAME(std::size_t capacity);
#include "pagestore/policies/table.inc"
#undef ATRIUM_POLICY

}  // namespace atrium
