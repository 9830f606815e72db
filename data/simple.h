// The small scenes: a Cornell-like room, furnaces and a grid of rooms.
#pragma once

#include "data/generate.h"

namespace atrium::generator {

GeneratedModel cornell(std::uint64_t seed);

// Closed, every surface of reflectance rho and exitance M: radiosity is M ÷ (1 − rho) everywhere.
Result<GeneratedModel> furnace(const std::string& shape, double rho, double exitance);

// K×K rooms joined by doorways, a lamp and a few boxes in each; every surface, the lamps too, of
// reflectance rho if it is given.
GeneratedModel grid_of_rooms(int k, std::optional<double> rho, std::uint64_t seed);

}  // namespace atrium::generator
