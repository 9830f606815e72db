// Stairs that turn round in a stairwell: per storey a flight up to a half landing, a flight back, a
// landing. Flights start `kLandingLap` on the landing below, so that their foot stands on it.
#pragma once

#include "data/plan.h"

namespace atrium::generator {

inline constexpr int kStoreyPitch = 3600, kStoreyHeight = 2700;  // mm, floor to floor; clear
inline constexpr int kStairWidth = 2700, kStairLength = 5500;    // mm, the stairwell's floor

// In `well`, kStairWidth wide (x) and kStairLength long (y), its doors in the south wall: up
// through `storeys` more storeys; with none, half a storey: the part of a longer stair that one
// floor shows.
void build_stairs(ModelBuilder& out, PaintId paint, const Room& well, int storeys);

// Heights above the well's floor where a lamp hangs before the south wall and the north wall.
inline constexpr int kStairLampSouth = 2450, kStairLampNorth = 3900;  // mm, of each storey

}  // namespace atrium::generator
