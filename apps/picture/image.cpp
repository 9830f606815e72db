#include "apps/picture/image.h"

namespace atrium {

Image shrink(const Image& image, int side) {
  Image small(image.width / side, image.height / side);
  const float share = 1.0f / static_cast<float>(side * side);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
          for (std::size_t c = 0; c < 3; ++c)
            small.at(x, y)[c] += share * image.at(x * side + i, y * side + j)[c];
  return small;
}

}  // namespace atrium
