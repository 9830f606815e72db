// Furnishing a room by its use: workstations and bookcases along the walls of offices, desks in
// rows in open areas, tables in classrooms, plants in corridors.
#pragma once

#include "data/furniture.h"
#include "data/storeys.h"

namespace atrium::generator {

// Pieces go where the room's floor is free, and what they take is taken from then on.
void furnish_room(ModelBuilder& out, const FurniturePaints& paints, Furnish grade, Use use,
                  Room& room, std::uint64_t seed);

}  // namespace atrium::generator
