// An image of three floats a pixel, rows from the top.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace atrium {

using Pixel = std::array<float, 3>;

struct Image {
  int width = 0, height = 0;
  std::vector<Pixel> pixels;

  Image() = default;
  Image(int w, int h) : width(w), height(h), pixels(std::size_t(w) * std::size_t(h)) {}
  Pixel& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
  const Pixel& at(int x, int y) const {
    return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)];
  }
};

// The mean of each side × side pixels becomes one.
Image shrink(const Image& image, int side);

}  // namespace atrium
