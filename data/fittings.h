// What the rooms of the paper's models are painted with and fitted out with: doors, windows,
// radiators, pipes, lamps.
#pragma once

#include <string>

#include "data/plan.h"

namespace atrium::generator {

struct Palette {
  PaintId wall, ceiling, floor, carpet, concrete, base, frame, reveal, leaf, glazing, blind, board,
      grille, metal, stair;
  PaintId lamp, housing, sign;
};

// lamp: the luminance of the lamps, cd/m².
Palette make_palette(ModelBuilder& out, double lamp);

inline constexpr int kDoorWidth = 900, kDoorHeight = 2100;   // mm
inline constexpr int kWindowSill = 900, kWindowHead = 2300;  // mm above the floor
inline constexpr int kWindowDepth = 250, kFrameWidth = 60;   // mm
inline constexpr int kBaseHeight = 100;                      // mm

// A window from a0 to a1 along the wall, its blind drawn: closed, as the paper's building is lit
// by lamps alone.
Recess window(const Palette& p, const std::string& name, int room, Side side, int a0, int a1,
              int floor);

// A shut door from a0 on along the wall, with two small panes in its leaf.
Recess shut_door(const Palette& p, const std::string& name, int room, Side side, int a0, int floor);

// A doorway with steel frames flush in either wall.
Opening doorway(const Palette& p, const std::string& name, int a, int b, Side side, int a0,
                int floor);

// Before the stretch [a0, a1] of a wall, clear of wall and floor.
struct Radiator {
  std::string name;
  int room = 0;
  Side side = Side::kWest;
  int a0 = 0, a1 = 0;
};
// Takes the floor before it.
void claim_floor(Plan& plan, const Radiator& r);
void build_radiator(ModelBuilder& out, const Palette& p, const Room& room, const Radiator& r);

// An upright pipe or column from floor to ceiling, of a regular polygon.
struct Pipe {
  std::string name;
  int room = 0;
  Vec2 center{0};  // m
  int sides = 4;
  double radius = 0;  // m
};
void build_pipe(ModelBuilder& out, PaintId paint, const Room& room, const Pipe& pipe);

// A linear lamp of three luminous faces (below and at its sides), hung from its wires with
// `center` in the middle of its top.
void linear_lamp(ModelBuilder& out, const Palette& p, const std::string& name, const Vec3& center,
                 bool along_x);
inline constexpr int kLampLights = 3;
inline constexpr double kLampLength = 1.2, kLampDrop = .35;  // m

// A sign about `center`, its one luminous face towards `side`.
void exit_sign(ModelBuilder& out, const Palette& p, const std::string& name, const Vec3& center,
               Side side);
inline constexpr int kSignLights = 1;

}  // namespace atrium::generator
