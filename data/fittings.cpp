#include "data/fittings.h"

#include <cmath>

namespace atrium::generator {
namespace {

constexpr double kSignLuminance = 300;  // cd/m², green

constexpr int kRadiatorFromWall = 50, kRadiatorDepth = 100;  // mm
constexpr int kRadiatorBottom = 150, kRadiatorTop = 700;     // mm
constexpr int kRadiatorClearance = 200;                      // mm of floor before wall it takes

}  // namespace

Palette make_palette(ModelBuilder& out, double lamp) {
  Palette p;
  p.wall = out.paint("wall", {.72, .71, .67});
  p.ceiling = out.paint("ceiling", {.82, .82, .80});
  p.floor = out.paint("vinyl", {.34, .31, .27});
  p.carpet = out.paint("carpet", {.22, .25, .30});
  p.concrete = out.paint("concrete", {.42, .41, .39});
  p.base = out.paint("cove_base", {.16, .15, .15});
  p.frame = out.paint("steel_frame", {.30, .36, .38});
  p.reveal = out.paint("reveal", {.62, .61, .58});
  p.leaf = out.paint("door_leaf", {.48, .33, .20});
  p.glazing = out.paint("dark_glass", {.08, .08, .09});
  p.blind = out.paint("blind", {.60, .58, .52});
  p.board = out.paint("board", {.80, .80, .81});
  p.grille = out.paint("grille", {.50, .50, .50});
  p.metal = out.paint("radiator", {.78, .77, .74});
  p.stair = out.paint("stair", {.38, .37, .36});
  p.lamp = out.paint("lamp", Spectrum(.6), Spectrum(1, .97, .9) * lamp);
  p.housing = out.paint("lamp_housing", Spectrum(.75));
  p.sign = out.paint("exit_sign", {.1, .4, .15}, Spectrum(.1, 1, .3) * kSignLuminance);
  return p;
}

Recess window(const Palette& p, const std::string& name, int room, Side side, int a0, int a1,
              int floor) {
  return {.name = name,
          .room = room,
          .side = side,
          .rect = {a0, a1, floor + kWindowSill, floor + kWindowHead},
          .depth = kWindowDepth,
          .reveal = p.reveal,
          .back = p.blind,
          .frame = {.width = kFrameWidth, .sill = true, .paint = p.frame},
          .back_name = "blind",
          .mullion = true};
}

Recess shut_door(const Palette& p, const std::string& name, int room, Side side, int a0,
                 int floor) {
  constexpr int kLeafFromWall = 100;
  return {.name = name,
          .room = room,
          .side = side,
          .rect = {a0, a0 + kDoorWidth, floor, floor + kDoorHeight},
          .depth = kLeafFromWall,
          .reveal = p.reveal,
          .back = p.leaf,
          .frame = {.width = kFrameWidth, .sill = false, .paint = p.frame},
          .back_name = "leaf",
          .panels = {{a0 + 600, a0 + 750, floor + 900, floor + 1300},
                     {a0 + 600, a0 + 750, floor + 1450, floor + 1850}},
          .panel = p.glazing};
}

Opening doorway(const Palette& p, const std::string& name, int a, int b, Side side, int a0,
                int floor) {
  return {.name = name,
          .a = a,
          .b = b,
          .side = side,
          .rect = {a0, a0 + kDoorWidth, floor, floor + kDoorHeight},
          .reveal = p.reveal,
          .frame = {.width = kFrameWidth, .sill = false, .paint = p.frame}};
}

void claim_floor(Plan& plan, const Radiator& r) {
  Room& room = plan.room(r.room);
  room.occupied.push_back(strip_before(room, r.side, r.a0, r.a1, kRadiatorClearance));
}

void build_radiator(ModelBuilder& out, const Palette& p, const Room& room, const Radiator& r) {
  const int near = room.wall_at(r.side) - outward(r.side) * kRadiatorFromWall;
  const int far = near - outward(r.side) * kRadiatorDepth;
  const Vec3 from = wall_point(r.side, near, r.a0, room.z0 + kRadiatorBottom);
  const Vec3 to = wall_point(r.side, far, r.a1, room.z0 + kRadiatorTop);
  out.begin(room.name + "/" + r.name);
  out.box(p.metal, glm::min(from, to), glm::max(from, to));
}

void build_pipe(ModelBuilder& out, PaintId paint, const Room& room, const Pipe& pipe) {
  out.begin(room.name + "/" + pipe.name);
  out.stump(paint, pipe.center, pipe.sides, pipe.radius, metres(room.z0), pipe.radius,
            metres(room.z1), kTopFace | kBottomFace);
}

void linear_lamp(ModelBuilder& out, const Palette& p, const std::string& name, const Vec3& center,
                 bool along_x) {
  constexpr double kTop = .16 / 2, kBottom = .10 / 2, kHeight = .08, kEnd = kLampLength / 2;
  const auto at = [&](double along, double across, double z) {
    return center + (along_x ? Vec3(along, across, z) : Vec3(-across, along, z));
  };
  out.begin(name);
  out.face(p.lamp, {at(-kEnd, kBottom, -kHeight), at(kEnd, kBottom, -kHeight),
                    at(kEnd, -kBottom, -kHeight), at(-kEnd, -kBottom, -kHeight)});
  out.face(p.lamp, {at(-kEnd, -kBottom, -kHeight), at(kEnd, -kBottom, -kHeight), at(kEnd, -kTop, 0),
                    at(-kEnd, -kTop, 0)});
  out.face(p.lamp, {at(kEnd, kBottom, -kHeight), at(-kEnd, kBottom, -kHeight), at(-kEnd, kTop, 0),
                    at(kEnd, kTop, 0)});
  out.face(p.housing,
           {at(-kEnd, -kTop, 0), at(kEnd, -kTop, 0), at(kEnd, kTop, 0), at(-kEnd, kTop, 0)});
  out.face(p.housing, {at(kEnd, -kBottom, -kHeight), at(kEnd, kBottom, -kHeight), at(kEnd, kTop, 0),
                       at(kEnd, -kTop, 0)});
  out.face(p.housing, {at(-kEnd, kBottom, -kHeight), at(-kEnd, -kBottom, -kHeight),
                       at(-kEnd, -kTop, 0), at(-kEnd, kTop, 0)});
}

void exit_sign(ModelBuilder& out, const Palette& p, const std::string& name, const Vec3& center,
               Side side) {
  constexpr double kWidth = .3, kHeight = .15, kDepth = .04;
  const int axis = axis_of(side);
  Vec3 half(kWidth / 2, kWidth / 2, kHeight / 2);
  half[axis] = kDepth / 2;
  const Vec3 lo = center - half, hi = center + half;
  Vec3 from = lo, to = hi;
  (outward(side) > 0 ? from : to)[axis] = (outward(side) > 0 ? hi : lo)[axis];
  out.begin(name);
  out.rectangle(p.sign, axis, outward(side), from, to);
  out.box(p.housing, lo, hi, 1u << static_cast<int>(side));
}

}  // namespace atrium::generator
