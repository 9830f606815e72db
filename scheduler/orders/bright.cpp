// Bright order gathers first where most light will have arrived after one bounce, as progressive
// radiosity shoots first from where most is unshot [Cohen, Chen, Wallace, Greenberg 88]: what
// comes later gathers from it. Known beforehand are what clusters emit, how much they reflect, and
// who may see whom; what stands in between or turns away is not asked.
#include <algorithm>
#include <numbers>
#include <utility>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

struct Light {
  double emitted = 0;    // lm, luminance
  double reflects = 0;   // m²: area times reflectance
};

std::vector<Light> light_of_clusters(const OrderTask& task) {
  std::vector<Light> light(task.model.clusters.size());
  for (const Patch& p : task.model.patches) {
    if (p.inert) continue;
    const double a = area(task.model.polygon(p));
    const Material& m = task.materials[p.material.value];
    light[p.cluster.value].emitted += a * luminance(m.exitance);
    light[p.cluster.value].reflects += a * luminance(m.reflectance);
  }
  return light;
}

// m⁻²: a form factor ÷ the area that receives, of a source that shines evenly into a half space,
// and no nearer than its own size.
double falloff(const Box& a, const Box& b) {
  const Vec3 d = a.center() - b.center(), extent = b.extent();
  return 1 / (std::numbers::pi * (dot(d, d) + dot(extent, extent) / 4));
}

}  // namespace

Sequence bright_order(const OrderTask& task) {
  const Model& model = task.model;
  const std::vector<Light> light = light_of_clusters(task);
  std::vector<std::pair<double, std::uint32_t>> reflected;  // lm, negative: the brightest first
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c) {
    double density = 0;  // lm/m²
    for (const ClusterId s : model.visible[c])
      if (light[s.value].emitted > 0)
        density += light[s.value].emitted *
                   falloff(model.clusters[c].bounds, model.clusters[s.value].bounds);
    reflected.push_back({-density * light[c].reflects, c});
  }
  std::sort(reflected.begin(), reflected.end());
  Sequence s;
  for (const auto& [flux, c] : reflected) s.push_back(ClusterId(c));
  return s;
}

}  // namespace atrium
