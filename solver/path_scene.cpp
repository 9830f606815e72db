#include "solver/path_scene.h"

#include <algorithm>
#include <cmath>

#include "visibility/bsp.h"

namespace atrium {
namespace {

// A point's own normal, written in a file, may be so far off its surface's: 1 minus the cosine.
constexpr double kNormalsAgree = 1e-4;

std::vector<Box> boxes_of(const Scene& scene) {
  std::vector<Box> boxes;
  for (const Surface& s : scene.surfaces) boxes.push_back(bounds(scene.polygon(s)));
  return boxes;
}

std::vector<Plane> planes_of(const Scene& scene) {
  std::vector<Plane> planes;
  for (const Surface& s : scene.surfaces) planes.push_back(plane_of(scene.polygon(s)));
  return planes;
}

RayScene rays_of(const Scene& scene) {
  std::vector<BlockerPolygon> polygons;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i)
    polygons.push_back({scene.polygon(scene.surfaces[i]), static_cast<std::uint32_t>(i)});
  return RayScene(polygons);
}

Box about(const Vec3& x, double margin) { return {x - Vec3(margin), x + Vec3(margin)}; }

}  // namespace

PathScene::PathScene(const Scene& scene)
    : scene_(scene),
      planes_(planes_of(scene)),
      boxes_(boxes_of(scene)),
      rays_(rays_of(scene)),
      light_of_surface_(scene.surfaces.size(), kNoLight) {
  const Vec3 extent = scene.bounds.empty() ? Vec3(0) : scene.bounds.extent();
  near_ = kEndShrink * std::max({extent.x, extent.y, extent.z});
  for (std::uint32_t i = 0; i < scene.surfaces.size(); ++i) {
    const Surface& s = scene.surfaces[i];
    area_ += atrium::area(scene.polygon(s));
    if (s.sides != kNoSide && scene.materials[s.material.value].emits()) add_light(i);
  }
  find_stand_ins();
}

void PathScene::add_light(std::uint32_t surface) {
  const Surface& s = scene_.surfaces[surface];
  const PolygonView polygon = scene_.polygon(s);
  Light light{surface, static_cast<std::uint32_t>(triangles_.size()), 0, 0};
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const double part = fan_area(polygon, i);
    if (!(part > 0)) continue;
    triangles_.push_back({polygon[0], polygon[i - 1], polygon[i], light.area, part});
    light.area += part;
    ++light.triangle_count;
  }
  if (light.triangle_count == 0) return;
  light_of_surface_[surface] = static_cast<std::uint32_t>(lights_.size());
  lights_.push_back(light);
  const bool both = s.sides == kBothSides;
  const Vec3 normal = planes_[surface].normal;
  const Spectrum m = scene_.materials[s.material.value].exitance;
  outlines_.push_back({polygon, (m.x + m.y + m.z) * light.area * (both ? 2 : 1),
                       s.sides == kBack ? -normal : normal, both});
}

void PathScene::find_stand_ins() {
  const double slack = kSliverTolerances * scene_.tolerance;
  std::vector<std::uint32_t> row;
  for (std::uint32_t i = 0; i < scene_.surfaces.size(); ++i) {
    row.clear();
    const Surface& s = scene_.surfaces[i];
    const Plane& plane = planes_[i];
    Box box = bounds(scene_.polygon(s));
    if (s.sides != kBothSides)
      boxes_.visit({box.lo - Vec3(slack), box.hi + Vec3(slack)}, [&](std::uint32_t j) {
        if (j == i || scene_.surfaces[j].sides == kNoSide) return;
        const PolygonView other = scene_.polygon(scene_.surfaces[j]);
        if (std::all_of(other.begin(), other.end(),
                        [&](const Vec3& x) { return std::abs(plane.distance(x)) <= slack; }))
          row.push_back(j);
      });
    stand_ins_.push_row(row);
  }
}

// Who counts on this side of the surface, at a point of it.
std::optional<std::uint32_t> PathScene::stand_in(std::uint32_t surface, Sides side,
                                                 const Vec3& x) const {
  for (const std::uint32_t j : stand_ins_[surface]) {
    const Surface& s = scene_.surfaces[j];
    const bool same = dot(planes_[j].normal, planes_[surface].normal) > 0;
    const Sides its_side = same == (side == kFront) ? kFront : kBack;
    if ((s.sides & its_side) && contains(scene_.polygon(s), planes_[j].normal, x, scene_.tolerance))
      return j;
  }
  return std::nullopt;
}

MetSide PathScene::met(const Hit& hit, const Vec3& direction) const {
  const Sides side = dot(hit.normal, direction) < 0 ? kFront : kBack;
  MetSide met{.normal = side == kFront ? hit.normal : -hit.normal};
  std::uint32_t surface = hit.id;
  if (!(scene_.surfaces[surface].sides & side)) {
    const auto other = stand_in(surface, side, hit.point);
    if (!other) return met;
    surface = *other;
  }
  const Material& material = scene_.materials[scene_.surfaces[surface].material.value];
  met.reflectance = material.reflectance;
  met.exitance = material.exitance;
  met.light = light_of_surface_[surface];
  return met;
}

LightPoint PathScene::light_point(std::uint32_t light, const Vec2& square) const {
  const Light& l = lights_[light];
  const double at = square.x * l.area;
  const Triangle* t = &triangles_[l.first_triangle];
  const Triangle* last = t + l.triangle_count - 1;
  while (t != last && at >= t->before + t->area) ++t;
  const double share = std::clamp((at - t->before) / t->area, 0.0, 1.0);
  const Surface& surface = scene_.surfaces[l.surface];
  return {point_of(t->a, t->b, t->c, {share, square.y}), planes_[l.surface].normal,
          scene_.materials[surface.material.value].exitance, l.area, surface.sides};
}

Vec3 PathScene::on_surface(const Vec3& x, const Vec3& n, double tolerance) const {
  double nearest = std::numeric_limits<double>::infinity();
  Vec3 found = x;
  boxes_.visit(about(x, tolerance), [&](std::uint32_t i) {
    const Plane& plane = planes_[i];
    const double distance = plane.distance(x);
    if (std::abs(distance) > tolerance || std::abs(distance) >= nearest) return;
    if (std::abs(dot(plane.normal, n)) < 1 - kNormalsAgree) return;
    const Vec3 foot = x - distance * plane.normal;
    if (!contains(scene_.polygon(scene_.surfaces[i]), plane.normal, foot, tolerance)) return;
    nearest = std::abs(distance);
    found = foot;
  });
  return found;
}

}  // namespace atrium
