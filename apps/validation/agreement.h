// How far the light in one scene is from that in another at the same points, as the project has
// error: the difference in luminance divided by the larger of what is expected there and its mean,
// root mean square over the points.
#pragma once

#include <span>

namespace atrium {

// Not a number where a value is not, or nothing is expected anywhere. Equally many of both.
double nrmse(std::span<const double> found, std::span<const double> expected);

}  // namespace atrium
