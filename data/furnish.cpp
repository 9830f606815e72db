#include "data/furnish.h"

#include <algorithm>
#include <optional>

namespace atrium::generator {
namespace {

constexpr int kFromWall = 40, kStep = 100;  // mm
constexpr int kSquareMetresADesk = 7;
constexpr int kPlantEvery = 6;  // metres of corridor

// A footprint whose y looks towards `facing`.
Rect turned(const Rect& r, Side facing) {
  switch (facing) {
    case Side::kNorth:
      return r;
    case Side::kSouth:
      return {-r.a1, -r.a0, -r.b1, -r.b0};
    case Side::kEast:
      return {r.b0, r.b1, -r.a1, -r.a0};
    case Side::kWest:
      return {-r.b1, -r.b0, r.a0, r.a1};
  }
  return r;
}

double degrees(Side facing) {
  switch (facing) {
    case Side::kNorth:
      return 0;
    case Side::kSouth:
      return 180;
    case Side::kEast:
      return -90;
    case Side::kWest:
      return 90;
  }
  return 0;
}

std::optional<Placement> claim(Room& room, const Rect& footprint, Side facing, int x, int y) {
  const Rect t = turned(footprint, facing);
  const Rect r{x + t.a0, x + t.a1, y + t.b0, y + t.b1};
  const Rect& floor = room.area;
  if (r.a0 < floor.a0 || r.a1 > floor.a1 || r.b0 < floor.b0 || r.b1 > floor.b1) return {};
  if (std::ranges::any_of(room.occupied, [&](const Rect& o) { return o.overlaps(r); })) return {};
  room.occupied.push_back(r);
  return placed({metres(x), metres(y), metres(room.z0)}, degrees(facing));
}

// With its far edge along a wall: the walls in turn from `first` on, each from its start.
std::optional<Placement> claim_at_wall(Room& room, const Rect& footprint, int first) {
  for (int i = 0; i < 4; ++i) {
    const Side side = kSides[static_cast<std::size_t>((first + i) % 4)];
    const int at = room.wall_at(side) - outward(side) * (kFromWall + footprint.b1);
    const Rect wall = room.wall(side);
    for (int a = wall.a0; a < wall.a1; a += kStep) {
      const auto found = axis_of(side) == 0 ? claim(room, footprint, side, at, a)
                                            : claim(room, footprint, side, a, at);
      if (found) return found;
    }
  }
  return {};
}

// Every place of a grid over the floor that is free, `margin` from the walls.
std::vector<Placement> claim_grid(Room& room, const Rect& footprint, Side facing, int margin,
                                  int gap_x, int gap_y) {
  const Rect t = turned(footprint, facing);
  std::vector<Placement> places;
  for (int y = room.area.b0 + margin; y + t.b1 - t.b0 + margin <= room.area.b1;
       y += t.b1 - t.b0 + gap_y)
    for (int x = room.area.a0 + margin; x + t.a1 - t.a0 + margin <= room.area.a1;
         x += t.a1 - t.a0 + gap_x)
      if (const auto place = claim(room, footprint, facing, x - t.a0, y - t.b0))
        places.push_back(*place);
  return places;
}

// What is drawn for the layout and for the pieces themselves, apart: a room holds the same pieces
// whatever their grade.
struct RoomDice {
  Dice layout, pieces;
};

void furnish_office(Furnisher& f, Room& room, RoomDice& dice) {
  const double area = metres(room.area.a1 - room.area.a0) * metres(room.area.b1 - room.area.b0);
  const int desks = std::max(1, static_cast<int>(area / kSquareMetresADesk));
  const int first = dice.layout.integer(0, 1);
  for (int i = 1; i <= desks; ++i)
    if (const auto place = claim_at_wall(room, kWorkstation, first + i))
      workstation(f, i, *place, dice.pieces);
  for (int i = 1; i <= desks; ++i)
    if (const auto place = claim_at_wall(room, kBookcase, first + i))
      bookcase(f, i, *place, usual_book_faces(f.grade), dice.pieces);
  if (dice.layout.integer(0, 1))
    if (const auto place = claim_at_wall(room, kPlant, first)) plant(f, 1, *place, dice.pieces);
}

void furnish_open_area(Furnisher& f, Room& room, RoomDice& dice) {
  int number = 0;
  for (const Placement& place : claim_grid(room, kWorkstation, Side::kNorth, 900, 200, 500))
    workstation(f, ++number, place, dice.pieces);
  for (int i = 1; i <= number; ++i)
    if (const auto place = claim_at_wall(room, kBookcase, i % 4))
      bookcase(f, i, *place, usual_book_faces(f.grade), dice.pieces);
}

void furnish_classroom(Furnisher& f, Room& room) {
  int number = 0;
  for (const Placement& place : claim_grid(room, kSchoolTable, Side::kWest, 900, 400, 300))
    school_table(f, ++number, place);
}

void set_out_plants(Furnisher& f, Room& room, RoomDice& dice) {
  const Rect& r = room.area;
  const int plants = std::max(r.a1 - r.a0, r.b1 - r.b0) / 1000 / kPlantEvery;
  for (int i = 1; i <= plants; ++i)
    if (const auto place = claim_at_wall(room, kPlant, dice.layout.integer(0, 3)))
      plant(f, i, *place, dice.pieces);
}

}  // namespace

void furnish_room(ModelBuilder& out, const FurniturePaints& paints, Furnish grade, Use use,
                  Room& room, std::uint64_t seed) {
  Furnisher f{out, paints, grade, room.name};
  RoomDice dice{Dice(seed, room.name + "/layout"), Dice(seed, room.name)};
  switch (use) {
    case Use::kOffice:
      return furnish_office(f, room, dice);
    case Use::kOpen:
      return furnish_open_area(f, room, dice);
    case Use::kClassroom:
      return furnish_classroom(f, room);
    case Use::kCorridor:
    case Use::kAtrium:
      return set_out_plants(f, room, dice);
    case Use::kService:
    case Use::kStairs:
      return;
  }
}

}  // namespace atrium::generator
