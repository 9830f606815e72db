// A model under construction: groups of faces, the solids they are made of, and rectangles with
// holes. A ModelBuilder belongs to one thread.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <vector>

#include "data/generated_model.h"

namespace atrium::generator {

// Faces of an axis-aligned box, to be left out where it touches something.
enum BoxFaces : unsigned {
  kNoFace = 0,
  kWestFace = 1,  // towards -x
  kEastFace = 2,
  kSouthFace = 4,  // towards -y
  kNorthFace = 8,
  kBottomFace = 16,
  kTopFace = 32,
};

// Turns about z by an angle and moves: where a piece of furniture stands.
struct Placement {
  Vec3 origin{0};
  double cosine = 1, sine = 0;
  Vec3 operator()(const Vec3& p) const {
    return origin + Vec3(cosine * p.x - sine * p.y, sine * p.x + cosine * p.y, p.z);
  }
};
Placement placed(const Vec3& origin, double degrees);

class ModelBuilder {
 public:
  // The paint of that name; added if it is new.
  PaintId paint(const std::string& name, const Spectrum& reflectance,
                const Spectrum& luminance = Spectrum{0});

  // Faces go to the group begun last.
  void begin(std::string name);
  void face(PaintId paint, PolygonView corners);
  void face(PaintId paint, std::initializer_list<Vec3> corners) {
    face(paint, PolygonView(corners.begin(), corners.size()));
  }

  // The axis-parallel rectangle between lo and hi, which agree in `axis`; its normal points along
  // the axis if sign > 0, else against it.
  void rectangle(PaintId paint, int axis, int sign, const Vec3& lo, const Vec3& hi);

  // A solid seen from outside, without the faces of `omit`.
  void box(PaintId paint, const Vec3& lo, const Vec3& hi, unsigned omit = kNoFace,
           const Placement& at = {});
  // The outline, counter-clockwise in xy, drawn upwards from z0 to z1.
  void prism(PaintId paint, std::span<const Vec2> outline, double z0, double z1,
             unsigned omit = kNoFace, const Placement& at = {});
  // A regular n-gonal cone stump about the z axis through `center`, radius r0 at z0 and r1 at z1.
  void stump(PaintId paint, const Vec2& center, int sides, double r0, double z0, double r1,
             double z1, unsigned omit = kNoFace, const Placement& at = {});

  const GeneratedModel& model() const { return model_; }
  ModelCounts counts() const { return model_.counts(); }
  GeneratedModel take(std::string title);

 private:
  GeneratedModel model_;
};

// A rectangle in millimetres, in a plane of its own: plans are laid out in whole millimetres, so
// that faces that meet have equal coordinates to the bit.
struct Rect {
  int a0 = 0, a1 = 0, b0 = 0, b1 = 0;
  bool empty() const { return a0 >= a1 || b0 >= b1; }
  bool overlaps(const Rect& r) const { return a0 < r.a1 && r.a0 < a1 && b0 < r.b1 && r.b0 < b1; }
  Rect grown(int by) const { return {a0 - by, a1 + by, b0 - by, b1 + by}; }
};

inline double metres(int millimetres) { return millimetres / 1000.0; }

// What the holes leave of a rectangle, in few rectangles, no two of which can be rejoined. Holes do
// not overlap one another. Least in number where the holes stand in rows or columns.
std::vector<Rect> cut_out(const Rect& outer, std::span<const Rect> holes);

}  // namespace atrium::generator
