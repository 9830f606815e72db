#include <png.h>

#include "apps/picture/encode.h"
#include "apps/picture/tone.h"

namespace atrium {

Result<std::string> encode_png(const Image& image) {
  const std::vector<std::uint8_t> bytes = srgb_bytes(image);
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string file(size, '\0');
  if (png_image_write_to_memory(&header, file.data(), &size, 0, bytes.data(), 0, nullptr) == 0)
    return Status(Code::kInternal, "PNG", "", header.message);
  file.resize(size);
  return file;
}

}  // namespace atrium
