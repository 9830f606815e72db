#include "data/building.h"

#include <algorithm>
#include <cmath>

#include "data/furnish.h"
#include "data/storeys.h"
#include "engine/check.h"

namespace atrium::generator {
namespace {

// [THFH94, Table 3]
constexpr ModelCounts kPaperFloor{.clusters = 1761, .patches = 7054, .lights = 788};
constexpr ModelCounts kPaperBuilding{.clusters = 9625, .patches = 39979, .lights = 7826};

constexpr double kFloorLuminance = 4600, kBuildingLuminance = 2400;  // cd/m²: some 500 lx
constexpr double kBuildingGap = 12;  // m, between the buildings of a campus

constexpr int kLeastPipe = 3, kMostPipe = 24;     // sides
constexpr double kPipeRadius = .05;               // m
constexpr int kPipeFromWall = 90;                 // mm, its axis
constexpr int kPipeSpace = 160, kPipeStep = 250;  // mm
constexpr int kCorridorPipes = 6;                 // for one in another room

ModelCounts scaled(const ModelCounts& paper, double by) {
  const auto of = [by](std::uint64_t n) {
    return static_cast<std::uint64_t>(std::llround(static_cast<double>(n) * by));
  };
  return {of(paper.clusters), of(paper.patches), of(paper.lights)};
}

class Building {
 public:
  Building(const StoreyOptions& options, const Palette& p, const ModelCounts& wanted)
      : options_(options), p_(p), storeys_(plan_storeys(options, p)) {
    share_lights(static_cast<int>(wanted.lights));
    add_pipes(wanted);
  }

  // Walls, floors, ceilings and what is fixed to them, room by room.
  void build_structure(ModelBuilder& out) const {
    for (int i = 0; i < storeys_.plan.size(); ++i) {
      const Room& room = storeys_.plan.room(i);
      storeys_.plan.build(i, out);
      for (const Radiator& r : storeys_.radiators)
        if (r.room == i) build_radiator(out, p_, room, r);
      for (const Pipe& c : storeys_.columns)
        if (c.room == i) build_pipe(out, p_.concrete, room, c);
      for (const Pipe& c : pipes_)
        if (c.room == i) build_pipe(out, p_.metal, room, c);
      if (storeys_.uses[static_cast<std::size_t>(i)] == Use::kStairs)
        build_stairs(out, p_.stair, room, storeys_.storeys - 1);
    }
  }

  void build_lamps(ModelBuilder& out) const {
    for (std::size_t i = 0; i < storeys_.lamps.size(); ++i)
      build_zone(out, storeys_.lamps[i], lamps_in_[i]);
    for (int i = 0; i < signs_; ++i) {
      const Sign& s = storeys_.signs[static_cast<std::size_t>(i)];
      exit_sign(out, p_, s.name, s.center, s.side);
    }
  }

  void build_furniture(ModelBuilder& out, const FurniturePaints& paints, Furnish grade) {
    for (int i = 0; i < storeys_.plan.size(); ++i)
      furnish_room(out, paints, grade, storeys_.uses[static_cast<std::size_t>(i)],
                   storeys_.plan.room(i), options_.seed);
  }

 private:
  // Lamps by weight, largest remainders first; what three lights a lamp leave over, and a sign over
  // each stairwell's door, are signs.
  void share_lights(int lights) {
    const int most = static_cast<int>(storeys_.signs.size());
    signs_ = std::max(0, most - kLampLights + 1);
    while (signs_ < most && (lights - signs_ * kSignLights) % kLampLights != 0) ++signs_;
    int left = std::max(0, (lights - signs_ * kSignLights) / kLampLights);
    double weights = 0;
    for (const LampZone& z : storeys_.lamps) {
      left -= z.fixed;
      weights += z.weight;
    }
    std::vector<std::pair<double, std::size_t>> remainders;
    const int shared = left;
    for (const LampZone& z : storeys_.lamps) {
      const double share = z.fixed + shared * z.weight / weights;
      lamps_in_.push_back(static_cast<int>(share));
      left -= lamps_in_.back() - z.fixed;
      remainders.push_back({lamps_in_.back() - share, lamps_in_.size() - 1});
    }
    std::ranges::sort(remainders);
    for (int i = 0; i < left; ++i) ++lamps_in_[remainders[static_cast<std::size_t>(i)].second];
  }

  // In columns and rows over the zone, along its longer side.
  void build_zone(ModelBuilder& out, const LampZone& zone, int count) const {
    if (count == 0) return;
    const Rect& r = zone.area;
    const bool along_x = r.a1 - r.a0 >= r.b1 - r.b0;
    const double length = metres(along_x ? r.a1 - r.a0 : r.b1 - r.b0);
    const double width = metres(along_x ? r.b1 - r.b0 : r.a1 - r.a0);
    const double from = metres(along_x ? r.a0 : r.b0), across = metres(along_x ? r.b0 : r.a0);
    // Rows one above the other so that lamps stand about as far apart either way.
    const int fit = std::max(1, static_cast<int>(length / (kLampLength + .1)));
    int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(count * width / length))));
    rows = std::max(rows, (count + fit - 1) / fit);
    int number = 0;
    for (int row = 0; row < rows; ++row) {
      const int here = count * (row + 1) / rows - count * row / rows;
      for (int i = 0; i < here; ++i) {
        const double l = from + length * (i + .5) / here, w = across + width * (row + .5) / rows;
        linear_lamp(out, p_, zone.name + "/lamp" + std::to_string(++number),
                    {along_x ? l : w, along_x ? w : l, metres(zone.z)}, along_x);
      }
    }
  }

  // Upright pipes and ducts along the walls make up what the structure leaves of the wanted counts.
  void add_pipes(const ModelCounts& wanted) {
    ModelBuilder bare;
    make_palette(bare, 1);
    build_structure(bare);
    build_lamps(bare);
    const ModelCounts have = bare.counts();
    const auto count = static_cast<int>(wanted.clusters) - static_cast<int>(have.clusters);
    const auto faces = static_cast<int>(wanted.patches) - static_cast<int>(have.patches);
    if (count <= 0 || faces < count * kLeastPipe || faces > count * kMostPipe) return;
    int made = 0;
    for (Pipe& pipe : pipe_spots(count)) {
      const std::int64_t all = faces;
      pipe.sides = static_cast<int>(all * (made + 1) / count - all * made / count);
      pipe.name = "pipe" + std::to_string(++made);
      pipes_.push_back(pipe);
    }
  }

  // Free spots along the walls, the rooms in turn: a spot each a turn, the nearest to the corners
  // first, but several in corridors, anywhere. Takes their floor.
  std::vector<Pipe> pipe_spots(int count) {
    std::vector<std::vector<Pipe>> free;
    int found = 0;
    for (int i = 0; i < storeys_.plan.size(); ++i) {
      free.push_back(spots_in(i));
      if (storeys_.uses[static_cast<std::size_t>(i)] == Use::kCorridor)
        shuffle(free.back(), Dice(options_.seed, storeys_.plan.room(i).name + "/pipes"));
      found += static_cast<int>(free.back().size());
    }
    std::vector<Pipe> spots;
    for (std::size_t turn = 0; static_cast<int>(spots.size()) < std::min(count, found); ++turn) {
      for (std::size_t room = 0; room < free.size(); ++room) {
        const bool corridor = storeys_.uses[room] == Use::kCorridor;
        const std::size_t each = corridor ? kCorridorPipes : 1;
        for (std::size_t k = turn * each; k < (turn + 1) * each && k < free[room].size(); ++k)
          if (static_cast<int>(spots.size()) < count) spots.push_back(free[room][k]);
      }
    }
    for (const Pipe& spot : spots)
      storeys_.plan.room(spot.room).occupied.push_back(pipe_space(spot.center));
    return spots;
  }

  static void shuffle(std::vector<Pipe>& pipes, Dice dice) {
    for (int i = static_cast<int>(pipes.size()) - 1; i > 0; --i)
      std::swap(pipes[static_cast<std::size_t>(i)],
                pipes[static_cast<std::size_t>(dice.integer(0, i))]);
  }

  static Rect pipe_space(const Vec2& center) {
    const int x = static_cast<int>(std::lround(center.x * 1000));
    const int y = static_cast<int>(std::lround(center.y * 1000));
    return Rect{x, x, y, y}.grown(kPipeSpace / 2);
  }

  std::vector<Pipe> spots_in(int index) const {
    const Use use = storeys_.uses[static_cast<std::size_t>(index)];
    if (use == Use::kStairs || use == Use::kAtrium) return {};
    const Room& room = storeys_.plan.room(index);
    std::vector<Rect> taken = room.occupied;
    std::vector<Pipe> spots;
    for (int from_corner = kPipeFromWall;; from_corner += kPipeStep) {
      bool any = false;
      for (Side s : kSides) {
        const Rect wall = room.wall(s);
        if (from_corner > (wall.a1 - wall.a0) / 2) continue;
        any = true;
        for (int along : {wall.a0 + from_corner, wall.a1 - from_corner}) {
          const Vec2 at(wall_point(s, room.wall_at(s) - outward(s) * kPipeFromWall, along, 0));
          const Rect space = pipe_space(at);
          if (std::ranges::any_of(taken, [&](const Rect& r) { return r.overlaps(space); }))
            continue;
          taken.push_back(space);
          spots.push_back({"", index, at, 0, kPipeRadius});
        }
      }
      if (!any) return spots;
    }
  }

  const StoreyOptions options_;
  const Palette& p_;  // outlives the building
  Storeys storeys_;
  std::vector<int> lamps_in_;  // by zone
  int signs_ = 0;
  std::vector<Pipe> pipes_;
};

}  // namespace

GeneratedModel building(const BuildingOptions& options, const std::string& title) {
  const bool tall = options.storeys > 1;
  const int offices = options.rooms > 0 ? offices_for(options.rooms) : kPaperOffices;
  const double size = static_cast<double>(offices) / kPaperOffices;
  const ModelCounts wanted = tall ? scaled(kPaperBuilding, size * options.storeys / kPaperStoreys)
                                  : scaled(kPaperFloor, size);
  ModelBuilder out;
  const Palette palette = make_palette(out, tall ? kBuildingLuminance : kFloorLuminance);
  std::vector<Building> buildings;
  for (int i = 0; i < options.buildings; ++i) {
    StoreyOptions o{.offices = offices, .storeys = options.storeys, .seed = options.seed};
    if (options.buildings > 1) o.name = "building" + std::to_string(i + 1) + "/";
    o.seed += static_cast<std::uint64_t>(i);
    o.origin = {i * (building_length(offices) + kBuildingGap), 0};
    buildings.emplace_back(o, palette, wanted);
  }
  for (const Building& b : buildings) b.build_structure(out);
  for (const Building& b : buildings) b.build_lamps(out);
  if (options.furnish != Furnish::kNone) {
    const FurniturePaints paints = furniture_paints(out, palette.lamp);
    for (Building& b : buildings) b.build_furniture(out, paints, options.furnish);
  }
  return out.take(title);
}

}  // namespace atrium::generator
