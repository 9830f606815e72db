// What is in a scene: the figures of `atrium inspect`, as plain data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/scene.h"

namespace atrium {

struct MaterialReport {
  std::string name;
  std::uint64_t faces = 0;  // polygons in the files
  double area = 0;          // m², every place once, however many sides count there
  Spectrum reflectance{0};
  double lumens = 0;  // lm, of all emitting sides
};

struct SceneReport {
  std::vector<std::string> files;
  std::uint64_t polygons = 0;  // in the files
  std::uint64_t patches = 0;   // rejoined, once however many sides
  std::uint64_t clusters = 0;  // objects with surfaces
  std::uint64_t lights = 0;    // emitting patches
  std::vector<MaterialReport> materials;
  Box bounds;         // metres, in the files' frame
  double area = 0;    // m²
  double lumens = 0;  // lm
  std::vector<Warning> warnings;
};

SceneReport inspect(const Scene& scene);

}  // namespace atrium
