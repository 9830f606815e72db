#include "data/plan.h"

#include <algorithm>
#include <utility>

#include "engine/check.h"

namespace atrium::generator {
namespace {

constexpr int kDoorClearance = 900;  // mm of floor kept free before a hole that people walk through
constexpr int kWalkable = 500;    // mm above the floor; a hole that begins lower is walked through
constexpr int kBarWidth = 50;     // mm, a mullion's, and its depth
constexpr int kBarFromPane = 60;  // mm
constexpr std::array<const char*, 4> kSideNames{"west", "east", "south", "north"};

std::string side_name(Side s) { return kSideNames[static_cast<std::size_t>(s)]; }

// A rectangle parallel to wall s, seen from inside the room.
void wall_face(ModelBuilder& out, PaintId paint, Side s, int across, const Rect& r) {
  out.rectangle(paint, axis_of(s), -outward(s), wall_point(s, across, r.a0, r.b0),
                wall_point(s, across, r.a1, r.b1));
}

void wall_group(ModelBuilder& out, const std::string& name, PaintId paint, Side s, int across,
                const Rect& outer, std::span<const Rect> holes) {
  const std::vector<Rect> pieces = cut_out(outer, holes);
  if (pieces.empty()) return;
  out.begin(name);
  for (const Rect& r : pieces) wall_face(out, paint, s, across, r);
}

// The four faces of a hole between planes c0 and c1, seen from within it.
void reveal_group(ModelBuilder& out, const std::string& name, PaintId paint, Side s, int c0, int c1,
                  const Rect& r) {
  const auto [lo, hi] = std::minmax(c0, c1);
  const int along = 1 - axis_of(s);
  out.begin(name);
  out.rectangle(paint, 2, 1, wall_point(s, lo, r.a0, r.b0), wall_point(s, hi, r.a1, r.b0));
  out.rectangle(paint, 2, -1, wall_point(s, lo, r.a0, r.b1), wall_point(s, hi, r.a1, r.b1));
  out.rectangle(paint, along, 1, wall_point(s, lo, r.a0, r.b0), wall_point(s, hi, r.a0, r.b1));
  out.rectangle(paint, along, -1, wall_point(s, lo, r.a1, r.b0), wall_point(s, hi, r.a1, r.b1));
}

// An upright bar that ends at the recess's sill and head.
void mullion_group(ModelBuilder& out, const std::string& name, const Recess& r, int back) {
  const int c0 = back - outward(r.side) * kBarFromPane, c1 = c0 - outward(r.side) * kBarWidth;
  const int a = (r.rect.a0 + r.rect.a1 - kBarWidth) / 2;
  const Vec3 p = wall_point(r.side, c0, a, r.rect.b0);
  const Vec3 q = wall_point(r.side, c1, a + kBarWidth, r.rect.b1);
  out.begin(name);
  out.box(r.frame.paint, glm::min(p, q), glm::max(p, q), kTopFace | kBottomFace);
}

Rect framed(const Rect& hole, const HoleFrame& frame) {
  Rect r = hole.grown(frame.width);
  if (!frame.sill) r.b0 = hole.b0;
  return r;
}

void cut_wall(Room& room, Side side, WallHole hole) {
  const Rect wall = room.wall(side), &cut = hole.framed;
  ATRIUM_CHECK(wall.a0 <= cut.a0 && cut.a1 <= wall.a1 && wall.b0 <= cut.b0 && cut.b1 <= wall.b1);
  auto& holes = room.holes[static_cast<std::size_t>(side)];
  for (const WallHole& other : holes) ATRIUM_CHECK(!other.framed.overlaps(cut));
  if (cut.b0 < room.z0 + kWalkable)
    room.occupied.push_back(strip_before(room, side, cut.a0, cut.a1, kDoorClearance));
  holes.push_back(std::move(hole));
}

}  // namespace

Vec3 wall_point(Side side, int across, int along, int z) {
  return axis_of(side) == 0 ? Vec3(metres(across), metres(along), metres(z))
                            : Vec3(metres(along), metres(across), metres(z));
}

Rect strip_before(const Room& room, Side side, int a0, int a1, int depth) {
  const Rect& r = room.area;
  switch (side) {
    case Side::kWest:
      return {r.a0, r.a0 + depth, a0, a1};
    case Side::kEast:
      return {r.a1 - depth, r.a1, a0, a1};
    case Side::kSouth:
      return {a0, a1, r.b0, r.b0 + depth};
    case Side::kNorth:
      return {a0, a1, r.b1 - depth, r.b1};
  }
  return {};
}

Rect Room::wall(Side s) const {
  return axis_of(s) == 0 ? Rect{area.b0, area.b1, z0, z1} : Rect{area.a0, area.a1, z0, z1};
}

int Room::wall_at(Side s) const {
  switch (s) {
    case Side::kWest:
      return area.a0;
    case Side::kEast:
      return area.a1;
    case Side::kSouth:
      return area.b0;
    case Side::kNorth:
      return area.b1;
  }
  return 0;
}

int Plan::add(Room room) {
  ATRIUM_CHECK(!room.area.empty() && room.z0 < room.z1);
  rooms_.push_back(std::move(room));
  return size() - 1;
}

void Plan::add(const Opening& o) {
  const int from = room(o.a).wall_at(o.side), to = room(o.b).wall_at(opposite(o.side));
  ATRIUM_CHECK((to - from) * outward(o.side) > 0);
  const WallHole hole{o.rect, framed(o.rect, o.frame), o.frame.paint, o.name};
  cut_wall(room(o.a), o.side, hole);
  cut_wall(room(o.b), opposite(o.side), hole);
  openings_.push_back(o);
}

void Plan::add(const Recess& r) {
  cut_wall(room(r.room), r.side, {r.rect, framed(r.rect, r.frame), r.frame.paint, r.name});
  recesses_.push_back(r);
}

void Plan::add(const Panel& p) { cut_wall(room(p.room), p.side, {{}, p.rect, p.paint, p.name}); }

void Plan::build(int i, ModelBuilder& out) const {
  const Room& room = rooms_[static_cast<std::size_t>(i)];
  const Rect& r = room.area;
  const std::string prefix = room.name + "/";
  out.begin(prefix + "floor");
  out.rectangle(room.finish.floor, 2, 1, {metres(r.a0), metres(r.b0), metres(room.z0)},
                {metres(r.a1), metres(r.b1), metres(room.z0)});
  const auto ceiling = [&](PaintId paint, const Rect& c) {
    out.rectangle(paint, 2, -1, {metres(c.a0), metres(c.b0), metres(room.z1)},
                  {metres(c.a1), metres(c.b1), metres(room.z1)});
  };
  out.begin(prefix + "ceiling");
  for (const Rect& c : cut_out(r, room.ceiling_panels)) ceiling(room.finish.ceiling, c);
  for (std::size_t k = 0; k < room.ceiling_panels.size(); ++k) {
    out.begin(prefix + "ceiling_panel" + std::to_string(k + 1));
    ceiling(room.ceiling_panel, room.ceiling_panels[k]);
  }
  build_walls(room, out);
  for (const Opening& o : openings_) {
    if (o.a != i) continue;
    reveal_group(out, prefix + o.name + "/reveal", o.reveal, o.side, room.wall_at(o.side),
                 rooms_[static_cast<std::size_t>(o.b)].wall_at(opposite(o.side)), o.rect);
  }
  for (const Recess& c : recesses_) {
    if (c.room != i) continue;
    const int front = room.wall_at(c.side), back = front + outward(c.side) * c.depth;
    reveal_group(out, prefix + c.name + "/reveal", c.reveal, c.side, front, back, c.rect);
    wall_group(out, prefix + c.name + "/" + c.back_name, c.back, c.side, back, c.rect, c.panels);
    if (!c.panels.empty()) {
      out.begin(prefix + c.name + "/panels");
      for (const Rect& p : c.panels) wall_face(out, c.panel, c.side, back, p);
    }
    if (c.mullion) mullion_group(out, prefix + c.name + "/mullion", c, back);
  }
}

void Plan::build_walls(const Room& room, ModelBuilder& out) const {
  const std::string prefix = room.name + "/";
  for (Side s : kSides) {
    std::vector<Rect> holes;
    for (const WallHole& h : room.holes_in(s)) holes.push_back(h.framed);
    Rect wall = room.wall(s), base = wall;
    wall.b0 = base.b1 = room.z0 + room.finish.base_height;
    wall_group(out, prefix + "wall_" + side_name(s), room.finish.wall, s, room.wall_at(s), wall,
               holes);
    if (!base.empty())
      wall_group(out, prefix + "base_" + side_name(s), room.finish.base, s, room.wall_at(s), base,
                 holes);
  }
  for (Side s : kSides) {
    for (const WallHole& h : room.holes_in(s))
      wall_group(out, prefix + h.name + (h.rect.empty() ? "" : "/frame"), h.frame, s,
                 room.wall_at(s), h.framed, std::span(&h.rect, 1));
  }
}

}  // namespace atrium::generator
