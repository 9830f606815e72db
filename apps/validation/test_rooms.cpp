#include "apps/validation/test_rooms.h"

#include <numbers>

namespace atrium {

void add_room(generator::ModelBuilder& out, PaintId paint, const Vec3& size) {
  const auto side = [&](const char* name, int axis, int sign) {
    Vec3 lo{0}, hi = size;
    (sign > 0 ? hi : lo)[axis] = sign > 0 ? 0 : size[axis];
    out.begin(name);
    out.rectangle(paint, axis, sign, lo, hi);
  };
  side("room/floor", 2, 1);
  side("room/ceiling", 2, -1);
  side("room/wall_west", 0, 1);
  side("room/wall_east", 0, -1);
  side("room/wall_south", 1, 1);
  side("room/wall_north", 1, -1);
}

void add_lamp(generator::ModelBuilder& out, PaintId lamp, const LampPlace& at, double height) {
  out.begin("room/lamp");
  out.rectangle(lamp, 2, -1, {at.x0, at.y0, height}, {at.x1, at.y1, height});
}

GeneratedModel lamp_lit_room(double reflectance, const Vec3& size, const LampPlace& lamp,
                             double flux) {
  generator::ModelBuilder out;
  add_room(out, out.paint("grey", Spectrum{reflectance}), size);
  const Spectrum luminance{lamp_luminance(flux, lamp.area())};
  add_lamp(out, out.paint("lamp", Spectrum{reflectance}, luminance), lamp, size.z);
  return out.take("lamp-lit room");
}

Result<GeneratedModel> furnished_room(const std::string& kind, double reflectance) {
  GenerateOptions options{.kind = kind};
  if (kind == "rooms") options.grid = 1;
  Result<GeneratedModel> model = generate(options);
  if (!model.ok()) return model.status();
  for (Paint& p : model->paints) p.reflectance = Spectrum{reflectance};
  return model;
}

double lamp_luminance(double flux, double area) { return flux / (std::numbers::pi * area); }

double flux_of(const GeneratedModel& model) {
  double flux = 0;
  for (const GeneratedFace& f : model.faces)
    flux += std::numbers::pi * luminance(model.paints[f.paint].luminance) * area(model.polygon(f));
  return flux;
}

}  // namespace atrium
