// A plan: box-shaped rooms apart by a wall's thickness, openings through the walls between them,
// and recesses (windows, closed doors) that end inside a wall. Walls, floors and ceilings are cut
// exactly where the openings and their frames lie: nothing overlaps and the air stays closed.
//
// Invariants, in whole millimetres:
//  1. Rooms do not overlap. An opening runs from a wall of one room to the facing wall of another.
//  2. Openings and recesses of one wall keep apart, frames included.
// A Plan belongs to one thread.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "data/shapes.h"

namespace atrium::generator {

enum class Side { kWest, kEast, kSouth, kNorth };  // the walls at x0, x1, y0, y1
inline constexpr std::array kSides{Side::kWest, Side::kEast, Side::kSouth, Side::kNorth};
inline Side opposite(Side s) { return static_cast<Side>(static_cast<int>(s) ^ 1); }
inline int axis_of(Side s) { return s == Side::kWest || s == Side::kEast ? 0 : 1; }
inline int outward(Side s) { return s == Side::kWest || s == Side::kSouth ? -1 : 1; }

struct Finish {
  PaintId floor = 0, ceiling = 0, wall = 0;
  PaintId base = 0;     // the cove base, a flush strip of `base_height` along the floor
  int base_height = 0;  // mm; 0: none
};

// A hole in a wall: a along it (x or y), b upwards. A flush frame fills `framed` around `rect`,
// which is empty for a panel.
struct WallHole {
  Rect rect, framed;
  PaintId frame = 0;
  std::string name;
};

struct Room {
  std::string name;
  Rect area;           // a is x, b is y
  int z0 = 0, z1 = 0;  // mm
  Finish finish;
  std::vector<Rect> ceiling_panels = {};  // flush in the ceiling
  PaintId ceiling_panel = 0;
  std::array<std::vector<WallHole>, 4> holes = {};  // by Side
  std::vector<Rect> occupied = {};                  // of the floor: nothing more may stand there

  Rect wall(Side s) const;    // its rectangle
  int wall_at(Side s) const;  // its plane
  const std::vector<WallHole>& holes_in(Side s) const { return holes[static_cast<std::size_t>(s)]; }
};

// The frame around a hole in a wall; a door's has no sill.
struct HoleFrame {
  int width = 0;  // mm
  bool sill = false;
  PaintId paint = 0;
};

// Through the wall between rooms a and b; a's wall is `side`, b's the opposite one.
struct Opening {
  std::string name;
  int a = 0, b = 0;
  Side side = Side::kWest;
  Rect rect;
  PaintId reveal = 0;
  HoleFrame frame = {};
};

// Into the wall, away from the room.
struct Recess {
  std::string name;
  int room = 0;
  Side side = Side::kWest;
  Rect rect;
  int depth = 0;  // mm
  PaintId reveal = 0, back = 0;
  HoleFrame frame = {};
  std::string back_name = {};     // "pane", "leaf"
  std::vector<Rect> panels = {};  // flush in the back
  PaintId panel = 0;
  bool mullion = false;  // an upright bar in the middle
};

// Flush in a wall: a board, a cabinet's door.
struct Panel {
  std::string name;
  int room = 0;
  Side side = Side::kWest;
  Rect rect;
  PaintId paint = 0;
};

class Plan {
 public:
  int add(Room room);  // its index
  void add(const Opening& opening);
  void add(const Recess& recess);
  void add(const Panel& panel);

  Room& room(int i) { return rooms_[static_cast<std::size_t>(i)]; }
  const Room& room(int i) const { return rooms_[static_cast<std::size_t>(i)]; }
  int size() const { return static_cast<int>(rooms_.size()); }

  // Room i's floor, ceiling, walls, frames, recesses, and the reveals of the openings it owns.
  void build(int i, ModelBuilder& out) const;

 private:
  void build_walls(const Room& room, ModelBuilder& out) const;

  std::vector<Room> rooms_;
  std::vector<Opening> openings_;
  std::vector<Recess> recesses_;
};

// The strip of floor before the stretch [a0, a1] of a wall, `depth` deep.
Rect strip_before(const Room& room, Side side, int a0, int a1, int depth);

// A wall-parallel point: `across` from the origin along the wall's normal axis. Millimetres to m.
Vec3 wall_point(Side side, int across, int along, int z);

}  // namespace atrium::generator
