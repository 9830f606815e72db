// Render: a picture of a solution by one ray a sample, Gouraud shaded.
#pragma once

#include "apps/picture/camera.h"
#include "apps/picture/image.h"
#include "apps/picture/lit_scene.h"

namespace atrium {

struct RenderOptions {
  Camera camera;
  int side = 2;       // side × side samples a pixel
  bool mesh = false;  // the elements' edges on top
  // What lies above this plane is left out: dot(cut.normal, x) > cut.offset.
  std::optional<Plane> cut;
  int threads = 0;  // 0: all there are
};

// What the samples saw, in `side` times the camera's width and height.
struct Rendering {
  Image luminance;                 // B/π, cd/m²
  std::vector<std::uint8_t> what;  // Seen, a sample
};
enum Seen : std::uint8_t { kNothing = 0, kSurface = 1, kLamp = 2, kEdge = 3 };

Result<Rendering> render(LitScene& scene, const RenderOptions& options);

}  // namespace atrium
