// Tone: from cd/m² to what a screen shows. Exposure E in EV scales luminance by 2^E, so that 1 is
// the screen's white; up to the shoulder the scale is linear, above it bright lamps run out softly.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "apps/picture/image.h"

namespace atrium {

// A luminance and how much of the picture, or of the scene, has it.
struct Weighted {
  double luminance = 0;  // cd/m²
  double weight = 0;
};

// The exposure at which what is between darkness and lamps is well seen; 0 if all is dark.
// Takes its own copy to sort.
double automatic_exposure(std::vector<Weighted> values);

// cd/m² to 0..1, linear.
Pixel tone_mapped(const Pixel& luminance, double exposure_ev);

// Linear 0..1 to bytes of sRGB, three a pixel. [IEC 61966-2-1]
std::vector<std::uint8_t> srgb_bytes(const Image& image);

}  // namespace atrium
