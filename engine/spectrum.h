// Three physical channels, linear Rec.709 RGB. Exitance, irradiance and radiosity in lm/m².
#pragma once

#include "engine/vec.h"

namespace atrium {

using Spectrum = Vec3;

inline constexpr Spectrum kLuminanceWeights{0.2126, 0.7152, 0.0722};  // [Rec.709]

inline double luminance(const Spectrum& s) { return dot(kLuminanceWeights, s); }

}  // namespace atrium
