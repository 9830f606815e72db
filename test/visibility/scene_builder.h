// Scenes built by hand for the tests of the partition: rooms, walls, boxes, lamps, and moved
// copies.
#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <string>

#include "engine/scene.h"

namespace atrium {

class SceneBuilder {
 public:
  SceneBuilder() {
    scene_.materials.push_back({"grey", Spectrum{0.5}, Spectrum{0}});
    scene_.materials.push_back({"light", Spectrum{0.5}, Spectrum{100}});
  }

  SceneBuilder& polygon(const std::string& object, const Polygon& p, Sides sides = kFront,
                        bool emits = false) {
    Surface s;
    s.object = object_id(object);
    s.material = MaterialId(std::size_t(emits));
    s.first_vertex = static_cast<std::uint32_t>(scene_.vertices.size());
    s.vertex_count = static_cast<std::uint32_t>(p.size());
    s.sides = sides;
    scene_.vertices.insert(scene_.vertices.end(), p.begin(), p.end());
    scene_.surfaces.push_back(s);
    return *this;
  }

  // A rectangle from corner c along u, then v; it faces u × v.
  SceneBuilder& quad(const std::string& object, const Vec3& c, const Vec3& u, const Vec3& v,
                     Sides sides = kFront, bool emits = false) {
    return polygon(object, {c, c + u, c + u + v, c + v}, sides, emits);
  }

  // A lamp that shines down.
  SceneBuilder& lamp(const std::string& object, const Vec3& center, double size) {
    return quad(object, center - Vec3{0.5 * size, 0.5 * size, 0}, {0, size, 0}, {size, 0, 0},
                kFront, true);
  }

  // The six faces of a box, facing out; or in, the room inside it.
  SceneBuilder& box(const std::string& object, const Vec3& lo, const Vec3& hi,
                    bool inward = false) {
    const Vec3 d = hi - lo;
    for (int k = 0; k < 3; ++k)
      for (int upper = 0; upper < 2; ++upper) {
        Vec3 c = lo, u{0}, v{0};
        if (upper) c[k] = hi[k];
        u[(k + 1) % 3] = d[(k + 1) % 3];
        v[(k + 2) % 3] = d[(k + 2) % 3];
        if ((upper == 1) == inward) std::swap(u, v);
        quad(object, c, u, v);
      }
    return *this;
  }

  Scene build(const std::function<Vec3(const Vec3&)>& place = [](const Vec3& x) {
    return x;
  }) const {
    Scene scene = scene_;
    for (Vec3& x : scene.vertices) x = place(x);
    for (const Vec3& x : scene.vertices) scene.bounds.extend(x);
    scene.tolerance = kToleranceOfDiagonal * scene.bounds.diagonal();
    return scene;
  }

 private:
  ObjectId object_id(const std::string& name) {
    const auto [it, fresh] = ids_.try_emplace(name, ObjectId(scene_.objects.size()));
    if (fresh) scene_.objects.push_back({name, 0});
    return it->second;
  }

  Scene scene_;
  std::map<std::string, ObjectId> ids_;
};

inline Vec3 turned(const Vec3& x, double degrees) {
  const double a = degrees * M_PI / 180;
  return {std::cos(a) * x.x - std::sin(a) * x.y, std::sin(a) * x.x + std::cos(a) * x.y, x.z};
}

// Slabs and outer walls, `thick` metres, around a space from the origin to `end`: six boxes that
// touch, but for the north wall, which starts `foot` metres above the floor.
inline SceneBuilder shell_of_slabs(const Vec3& end, double thick, double foot = 0) {
  SceneBuilder s;
  s.box("floor", {-thick, -thick, -thick}, {end.x + thick, end.y + thick, 0});
  s.box("ceiling", {-thick, -thick, end.z}, {end.x + thick, end.y + thick, end.z + thick});
  s.box("west", {-thick, -thick, 0}, {0, end.y + thick, end.z});
  s.box("east", {end.x, -thick, 0}, {end.x + thick, end.y + thick, end.z});
  s.box("south", {0, -thick, 0}, {end.x, 0, end.z});
  s.box("north", {0, end.y, foot}, {end.x, end.y + thick, end.z});
  return s;
}

// Two rooms of 4 × 4 × 3 m, side by side along x, with a wall 0.2 m thick between them and a
// doorway of 1 × 2 m in it. One slab below and one above both. The lamp hangs in the first room.
inline SceneBuilder two_rooms_with_doorway() {
  constexpr double kThick = 0.2;
  const double x0 = 4, x1 = x0 + kThick, end = x1 + 4;
  SceneBuilder s;
  s.quad("floor", {0, 0, 0}, {end, 0, 0}, {0, 4, 0});
  s.quad("ceiling", {0, 0, 3}, {0, 4, 0}, {end, 0, 0});
  s.quad("west", {0, 0, 0}, {0, 4, 0}, {0, 0, 3});
  s.quad("east", {end, 0, 0}, {0, 0, 3}, {0, 4, 0});
  for (double from : {0.0, x1}) {
    s.quad("south", {from, 0, 0}, {0, 0, 3}, {4, 0, 0});
    s.quad("north", {from, 4, 0}, {4, 0, 0}, {0, 0, 3});
  }
  // The wall's two faces, in three parts each, around the doorway from y = 1 to 2.
  for (bool first : {true, false}) {
    auto part = [&](double y, double z, double dy, double dz) {
      const Vec3 u{0, dy, 0}, v{0, 0, dz};
      s.quad("wall", {first ? x0 : x1, y, z}, first ? v : u, first ? u : v);
    };
    part(0, 0, 1, 3);
    part(1, 2, 1, 1);
    part(2, 0, 2, 3);
  }
  s.quad("jambs", {x0, 1, 0}, {0, 0, 2}, {kThick, 0, 0});
  s.quad("jambs", {x0, 2, 0}, {kThick, 0, 0}, {0, 0, 2});
  s.quad("jambs", {x0, 1, 2}, {0, 1, 0}, {kThick, 0, 0});
  s.lamp("lamp", {2, 2, 2.9}, 0.5);
  return s;
}

// Three rooms of 4 m in a row, thin walls at x = 4 and 8, doorways at opposite ends: what leaves
// the lamp at y >= 1.75 and passes x = 4 at y < 1 falls further, and never reaches y > 3 at x = 8.
inline SceneBuilder rooms_in_a_row() {
  SceneBuilder s;
  s.box("shell", {0, 0, 0}, {12, 4, 3}, true);
  s.quad("wall 1", {4, 1, 0}, {0, 3, 0}, {0, 0, 3}, kBothSides);
  s.quad("wall 2", {8, 0, 0}, {0, 3, 0}, {0, 0, 3}, kBothSides);
  s.lamp("lamp", {2, 2, 2.9}, 0.5);
  s.box("second room", {6, 0.05, 1}, {6.5, 0.55, 1.5});
  s.box("second room's end", {4.5, 1.5, 1}, {5, 2, 1.5});
  s.box("third room", {9, 3.2, 1}, {9.5, 3.7, 1.5});
  return s;
}

}  // namespace atrium
