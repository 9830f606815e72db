// Picture files, as bytes. Equal images give equal bytes.
#pragma once

#include <string>

#include "apps/picture/image.h"
#include "engine/status.h"

namespace atrium {

// 8 bits, sRGB, of an image in linear 0..1.
Result<std::string> encode_png(const Image& image);
// 32-bit floats of linear Rec.709, as they are.
Result<std::string> encode_exr(const Image& image);

}  // namespace atrium
