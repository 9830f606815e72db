// The square of a number that is not worth a name of its own.
#pragma once

namespace atrium {

constexpr double squared(double x) { return x * x; }

}  // namespace atrium
