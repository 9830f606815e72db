#include "data/simple.h"

#include <cmath>
#include <numbers>

#include "data/dice.h"
#include "data/plan.h"

namespace atrium::generator {
namespace {

constexpr int kWallThickness = 200;  // mm
constexpr int kDoorWidth = 900, kDoorHeight = 2100;

constexpr double kCornellLuminance = 12000;  // cd/m², 0.5 m² of it: some 700 lx on the floor
constexpr double kRoomLuminance = 7000;      // cd/m², 0.72 m² of it in 20 m²

Spectrum grey(double value) { return Spectrum(value); }

Status usage(std::string cause, std::string remedy) {
  return {Code::kUsage, "gen", "", std::move(cause), std::move(remedy)};
}

// A box that stands on the floor, turned about its own middle.
void standing_box(ModelBuilder& out, PaintId paint, const Vec2& center, const Vec3& size,
                  double degrees) {
  const Vec3 half(size.x / 2, size.y / 2, 0);
  out.box(paint, -half, half + Vec3(0, 0, size.z), kBottomFace,
          placed({center.x, center.y, 0}, degrees));
}

// A doorway in the middle of the wall between rooms a and b.
Opening doorway(Plan& plan, int a, int b, Side side, PaintId reveal, const std::string& name) {
  const Rect wall = plan.room(a).wall(side);
  const int middle = (wall.a0 + wall.a1) / 2;
  return {
      .name = name,
      .a = a,
      .b = b,
      .side = side,
      .rect = {middle - kDoorWidth / 2, middle + kDoorWidth / 2, wall.b0, wall.b0 + kDoorHeight},
      .reveal = reveal,
      .frame = {}};
}

// columns × rows equal rooms with doorways between neighbours; room (i, j) has index j·columns + i.
Plan room_grid(int columns, int rows, const Vec2& size_mm, int height, const Finish& finish,
               PaintId reveal) {
  Plan plan;
  const int w = static_cast<int>(size_mm.x), d = static_cast<int>(size_mm.y);
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int x = i * (w + kWallThickness), y = j * (d + kWallThickness);
      plan.add(Room{.name = "room" + std::to_string(j + 1) + "_" + std::to_string(i + 1),
                    .area = {x, x + w, y, y + d},
                    .z1 = height,
                    .finish = finish});
    }
  }
  for (int r = 0; r < columns * rows; ++r) {
    if (r % columns + 1 < columns)
      plan.add(doorway(plan, r, r + 1, Side::kEast, reveal, "door_east"));
    if (r + columns < columns * rows)
      plan.add(doorway(plan, r, r + columns, Side::kNorth, reveal, "door_north"));
  }
  return plan;
}

void build_all(const Plan& plan, ModelBuilder& out) {
  for (int i = 0; i < plan.size(); ++i) plan.build(i, out);
}

void l_shaped_room(ModelBuilder& out, PaintId paint) {
  constexpr double kLong = 6, kShort = 2.5, kHeight = 3;
  const std::vector<Vec2> outline{{0, 0},           {kLong, 0},      {kLong, kShort},
                                  {kShort, kShort}, {kShort, kLong}, {0, kLong}};
  out.begin("room/floor");
  out.rectangle(paint, 2, 1, {0, 0, 0}, {kLong, kShort, 0});
  out.rectangle(paint, 2, 1, {0, kShort, 0}, {kShort, kLong, 0});
  out.begin("room/ceiling");
  out.rectangle(paint, 2, -1, {0, 0, kHeight}, {kLong, kShort, kHeight});
  out.rectangle(paint, 2, -1, {0, kShort, kHeight}, {kShort, kLong, kHeight});
  out.begin("room/walls");
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 p = outline[i], q = outline[(i + 1) % outline.size()];
    out.face(paint, {{q.x, q.y, 0}, {p.x, p.y, 0}, {p.x, p.y, kHeight}, {q.x, q.y, kHeight}});
  }
}

}  // namespace

GeneratedModel cornell(std::uint64_t seed) {
  constexpr double kSize = 5.5;
  constexpr Rect kPanel{2050, 3450, 2050, 3450};  // mm
  ModelBuilder out;
  const PaintId white = out.paint("white", {.75, .74, .70});
  const PaintId red = out.paint("red", {.60, .06, .06});
  const PaintId green = out.paint("green", {.14, .45, .09});
  const PaintId lamp = out.paint("lamp", grey(.5), Spectrum(1, .85, .6) * kCornellLuminance);

  const auto wall = [&](const char* name, PaintId paint, int axis, int sign, const Vec3& lo,
                        const Vec3& hi) {
    out.begin(name);
    out.rectangle(paint, axis, sign, lo, hi);
  };
  wall("room/floor", white, 2, 1, {0, 0, 0}, {kSize, kSize, 0});
  out.begin("room/ceiling");
  const auto metre_corner = [](int x, int y) { return Vec3(metres(x), metres(y), kSize); };
  for (const Rect& r : cut_out({0, 5500, 0, 5500}, std::span(&kPanel, 1)))
    out.rectangle(white, 2, -1, metre_corner(r.a0, r.b0), metre_corner(r.a1, r.b1));
  wall("room/wall_back", white, 1, -1, {0, kSize, 0}, {kSize, kSize, kSize});
  wall("room/wall_front", white, 1, 1, {0, 0, 0}, {kSize, 0, kSize});
  wall("room/wall_left", red, 0, 1, {0, 0, 0}, {0, kSize, kSize});
  wall("room/wall_right", green, 0, -1, {kSize, 0, 0}, {kSize, kSize, kSize});
  wall("room/lamp", lamp, 2, -1, metre_corner(kPanel.a0, kPanel.b0),
       metre_corner(kPanel.a1, kPanel.b1));

  Dice dice(seed, "cornell");
  const auto near = [&](double value, double by) { return value + dice.uniform(-by, by); };
  out.begin("room/furniture/short_box");
  standing_box(out, white, {near(3.7, .1), near(1.7, .1)}, {1.65, 1.65, 1.65}, near(-16.5, 3));
  out.begin("room/furniture/tall_box");
  standing_box(out, white, {near(1.85, .1), near(3.5, .1)}, {1.65, 1.65, 3.3}, near(22.5, 3));
  return out.take("cornell");
}

Result<GeneratedModel> furnace(const std::string& shape, double rho, double exitance) {
  constexpr int kHeight = 2700;
  ModelBuilder out;
  const PaintId paint = out.paint("furnace", grey(rho), grey(exitance / std::numbers::pi));
  const Finish finish{.floor = paint, .ceiling = paint, .wall = paint};
  const auto grid = [&](int columns, int rows, const Vec2& size_mm, int height) {
    build_all(room_grid(columns, rows, size_mm, height, finish, paint), out);
  };
  if (shape == "cube") {
    grid(1, 1, {3000, 3000}, 3000);
  } else if (shape == "l-room") {
    l_shaped_room(out, paint);
  } else if (shape == "two-rooms") {
    grid(2, 1, {4000, 3000}, kHeight);
  } else if (shape == "grid3x3") {
    grid(3, 3, {3500, 3000}, kHeight);
  } else {
    return usage("there is no furnace of the shape \"" + shape + "\"",
                 "take cube, l-room, two-rooms or grid3x3");
  }
  return out.take("furnace " + shape);
}

GeneratedModel grid_of_rooms(int k, std::optional<double> rho, std::uint64_t seed) {
  constexpr int kWidth = 5000, kDepth = 4000, kHeight = 2700;  // mm
  constexpr double kLampLength = 1.2, kLampWidth = .6, kLampHeight = .08, kLampDrop = .25;
  constexpr int kBoxes = 3;
  ModelBuilder out;
  const auto paint = [&](const char* name, const Spectrum& reflectance) {
    return out.paint(name, rho ? grey(*rho) : reflectance);
  };
  const Finish finish{.floor = paint("floor", {.32, .28, .24}),
                      .ceiling = paint("ceiling", grey(.8)),
                      .wall = paint("wall", {.70, .69, .65})};
  const PaintId reveal = paint("reveal", {.55, .5, .45});
  const std::array boxes{paint("box_blue", {.2, .3, .6}), paint("box_red", {.6, .22, .18}),
                         paint("box_pale", {.6, .58, .5})};
  const PaintId lamp = out.paint("lamp", grey(rho.value_or(.5)), grey(kRoomLuminance));
  const PaintId housing = paint("lamp_housing", grey(.7));

  Plan plan = room_grid(k, k, {kWidth, kDepth}, kHeight, finish, reveal);
  build_all(plan, out);
  for (int r = 0; r < plan.size(); ++r) {
    const Rect& a = plan.room(r).area;
    const Vec3 middle(metres(a.a0 + a.a1) / 2, metres(a.b0 + a.b1) / 2,
                      metres(kHeight) - kLampDrop);
    const Vec3 half(kLampLength / 2, kLampWidth / 2, 0);
    const Vec3 lo = middle - half - Vec3(0, 0, kLampHeight), hi = middle + half;
    out.begin(plan.room(r).name + "/lamp");
    out.rectangle(lamp, 2, -1, lo, {hi.x, hi.y, lo.z});
    out.box(housing, lo, hi, kBottomFace);
  }
  // The doorways are in the middle of the walls: boxes stand in three of the four quarters.
  for (int r = 0; r < plan.size(); ++r) {
    Dice dice(seed, plan.room(r).name);
    const Rect& a = plan.room(r).area;
    const int empty_quarter = dice.integer(0, 3);
    int made = 0;
    for (int q = 0; q < 4; ++q) {
      if (q == empty_quarter) continue;
      const Vec2 center(metres(q % 2 ? a.a1 - 1100 : a.a0 + 1100) + dice.uniform(-.2, .2),
                        metres(q / 2 ? a.b1 - 1000 : a.b0 + 1000) + dice.uniform(-.1, .1));
      const Vec3 size(dice.uniform(.4, 1), dice.uniform(.4, .8), dice.uniform(.4, 1.4));
      out.begin(plan.room(r).name + "/furniture/box" + std::to_string(++made));
      standing_box(out, boxes[static_cast<std::size_t>(made % kBoxes)], center, size,
                   dice.uniform(0, 90));
    }
  }
  return out.take("rooms " + std::to_string(k) + "x" + std::to_string(k));
}

}  // namespace atrium::generator
