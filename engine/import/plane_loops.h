// Closed loops of points in a plane: areas, angles, and loops made sound.
#pragma once

#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include "engine/vec.h"

namespace atrium {

using Ring = std::vector<std::uint32_t>;  // indices of points, closed, interior on the left

inline constexpr double kPi = std::numbers::pi;

inline double perp(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

// From direction a counter-clockwise to b, in [0, 2π).
double turn(const Vec2& a, const Vec2& b);

bool names_a_vertex_twice(const Ring& ring);

double signed_area(std::span<const Vec2> points, std::span<const std::uint32_t> ring);
double perimeter(std::span<const Vec2> points, std::span<const std::uint32_t> ring);

// The ring without corners within `tolerance` of the straight line between those kept.
Ring without_collinear(std::span<const Vec2> points, const Ring& ring, double tolerance);

// The loops that directed edges bound, pairs of opposite edges cancelled: a polygon with a
// keyhole becomes its outline and its hole. Loops that touch from inside are one.
std::vector<Ring> cancelled_loops(std::span<const Vec2> points, std::span<const Ring> rings);

// The same loops where nothing passes within `tolerance` of a corner without touching it: near
// corners become one, corners near edges are entered into them, and necks without width go.
std::vector<Ring> healed_loops(std::span<const Vec2> points, std::span<const Ring> rings,
                               double tolerance);

}  // namespace atrium
