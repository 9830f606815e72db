// Plain rooms for the suites of `atrium validate`: a corner at the origin, seen from inside. A lamp
// lies flush in the ceiling, in the same plane: where both are, import lets the emitter count.
#pragma once

#include <string>

#include "data/generate.h"
#include "data/shapes.h"

namespace atrium {

// An axis-parallel rectangle of a ceiling, m.
struct LampPlace {
  double x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  double area() const { return (x1 - x0) * (y1 - y0); }
};

inline LampPlace middle_of(const Vec3& room, double side) {
  return {(room.x - side) / 2, (room.y - side) / 2, (room.x + side) / 2, (room.y + side) / 2};
}

void add_room(generator::ModelBuilder& out, PaintId paint, const Vec3& size);
void add_lamp(generator::ModelBuilder& out, PaintId lamp, const LampPlace& at, double height);

// An empty room of one reflectance and a lamp of `flux` lm in its ceiling.
GeneratedModel lamp_lit_room(double reflectance, const Vec3& size, const LampPlace& lamp,
                             double flux);

// The generator's "cornell", or one of its "rooms", every surface of one reflectance.
Result<GeneratedModel> furnished_room(const std::string& kind, double reflectance);

// Luminance (cd/m²) of a Lambertian lamp that sends `flux` lm from `area` m².
double lamp_luminance(double flux, double area);

// All that a model's faces send out, luminance, lm.
double flux_of(const GeneratedModel& model);

}  // namespace atrium
