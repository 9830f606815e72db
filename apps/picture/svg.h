// What the program's drawings in SVG have in common.
#pragma once

#include <span>
#include <string>

#include "engine/vec.h"

namespace atrium {

// "12.0,3.5 14.2,3.5": the points of a polygon or a polyline, in px, to a tenth of one.
std::string svg_points(std::span<const Vec2> points);

// The largest of 1, 2 and 5 times a power of ten that is at most x; x > 0. The step of a scale.
double round_step(double x);

}  // namespace atrium
