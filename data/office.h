// The paper's office: Office, Office Low and Office High of Table 2.
#pragma once

#include "data/furniture.h"
#include "data/shapes.h"

namespace atrium::generator {

GeneratedModel office(Furnish furnish, std::uint64_t seed);

}  // namespace atrium::generator
