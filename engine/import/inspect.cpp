#include "engine/import/inspect.h"

#include <bit>

namespace atrium {

SceneReport inspect(const Scene& scene) {
  SceneReport report;
  report.files = scene.files;
  report.polygons = scene.polygons;
  report.patches = scene.patches;
  report.lights = scene.lights;
  report.warnings = scene.warnings;
  if (!scene.bounds.empty()) {
    report.bounds.lo = scene.bounds.lo + scene.frame.origin;
    report.bounds.hi = scene.bounds.hi + scene.frame.origin;
  }
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    report.materials.push_back({scene.materials[m].name, scene.faces_of_material[m], 0,
                                scene.materials[m].reflectance, 0});
  std::vector<bool> shown(scene.objects.size(), false);
  for (const Surface& s : scene.surfaces) {
    MaterialReport& m = report.materials[s.material.value];
    const double a = area(scene.polygon(s));
    // Where only a back counts, a front covers the place: that one is counted.
    if (s.sides & kFront) m.area += a;
    const int sides = std::popcount(static_cast<unsigned>(s.sides & kBothSides));
    m.lumens += luminance(scene.materials[s.material.value].exitance) * a * sides;
    shown[s.object.value] = true;
  }
  for (const MaterialReport& m : report.materials) {
    report.area += m.area;
    report.lumens += m.lumens;
  }
  for (const bool s : shown) report.clusters += s;
  return report;
}

}  // namespace atrium
