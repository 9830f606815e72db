#include "data/storeys.h"

#include <algorithm>
#include <cmath>

#include "data/dice.h"
#include "engine/check.h"

namespace atrium::generator {
namespace {

constexpr int kWall = 150;  // thickness of all walls between rooms
constexpr int kOfficeWidth = 3000, kOfficeDepth = 5000, kCorridorWidth = 2200, kCoreDepth = 9500;
constexpr int kPartitionMove = 200;  // at most, by the seed
constexpr int kOfficesASegment = 7;  // of corridor, about
constexpr int kWindowWidth = 1800;
constexpr int kPassageWidth = 1800, kPassageHeight = 2300;  // between stretches of corridor
constexpr int kWideOpening = 2400, kWideHeight = 2300;
constexpr int kGallerySill = 1000, kGalleryHead = 2400, kGalleryPitch = 3800;
constexpr int kAtriumWidth = 12000, kItemWidth = 9300;  // of the core, before stretching
constexpr int kAtriumFrom = 14;                         // offices along a corridor
constexpr int kSignHeight = 2450;
constexpr int kLampHeight = kStoreyHeight - 350;
constexpr double kCorridorWeight = .7, kAtriumWeight = 1.5;

// South to north.
constexpr int kSouthCorridor = kOfficeDepth + kWall;
constexpr int kCore = kSouthCorridor + kCorridorWidth + kWall;
constexpr int kNorthCorridor = kCore + kCoreDepth + kWall;
constexpr int kNorthOffices = kNorthCorridor + kCorridorWidth + kWall;

int length_of(int offices) { return offices * (kOfficeWidth + kWall) - kWall; }
int segments_of(int offices) {
  return std::max(1, (offices + kOfficesASegment / 2) / kOfficesASegment);
}

// What stands in the core between the stairwells, west to east.
struct CoreItem {
  Use use = Use::kOffice;  // kOffice: six inner offices, back to back
  int x0 = 0, x1 = 0;
};

std::vector<CoreItem> core_items(int offices) {
  const int west = kCorridorWidth + kWall + kStairWidth + kWall;
  const int east = length_of(offices) - west;
  const bool atrium = offices >= kAtriumFrom;
  const int room = east - west + kWall - (atrium ? kAtriumWidth + kWall : 0);
  const int count = std::max(1, (room + kItemWidth / 2) / (kItemWidth + kWall));
  const int width = room / count - kWall;
  constexpr std::array kTurns{Use::kClassroom, Use::kOffice, Use::kOpen, Use::kOffice};
  std::vector<CoreItem> items;
  int x = west;
  const auto add = [&](Use use, int w) {
    items.push_back({use, x, x + w});
    x += w + kWall;
  };
  for (int i = 0; i < count; ++i) {
    if (atrium && i == count / 2) add(Use::kAtrium, kAtriumWidth);
    add(kTurns[static_cast<std::size_t>(i) % kTurns.size()], width);
  }
  items.back().x1 = east;
  return items;
}

class StoreyPlanner {
 public:
  StoreyPlanner(const StoreyOptions& options, const Palette& p)
      : options_(options),
        p_(p),
        items_(core_items(options.offices)),
        x_(static_cast<int>(std::lround(options.origin.x * 1000))),
        y_(static_cast<int>(std::lround(options.origin.y * 1000))) {
    result_.storeys = options.storeys;
  }

  Storeys plan() {
    const auto item = std::ranges::find(items_, Use::kAtrium, &CoreItem::use);
    for (int level = 0; level < options_.storeys; ++level) plan_storey(level);
    if (item != items_.end()) plan_atrium(*item);
    const int x = kCorridorWidth + kWall;
    plan_stairwell("stairs_west", x);
    plan_stairwell("stairs_east", length_of(options_.offices) - x - kStairWidth);
    return std::move(result_);
  }

 private:
  // Rooms of a storey that others open into.
  struct Level {
    std::vector<int> south, north;  // stretches of corridor, west to east
  };

  std::string storey_name(int level) const {
    return options_.name + "floor" + std::to_string(level + 1) + "/";
  }

  int add_room(const std::string& name, Use use, Rect area, int z0, int height) {
    area = {area.a0 + x_, area.a1 + x_, area.b0 + y_, area.b1 + y_};
    const bool bare = use == Use::kStairs || use == Use::kService;
    const PaintId floor = bare ? p_.concrete : use == Use::kOffice ? p_.carpet : p_.floor;
    result_.uses.push_back(use);
    return result_.plan.add(Room{.name = name,
                                 .area = area,
                                 .z0 = z0,
                                 .z1 = z0 + height,
                                 .finish = {floor, p_.ceiling, p_.wall, p_.base, kBaseHeight}});
  }

  void add_zone(int room, int z, double weight) {
    const Room& r = result_.plan.room(room);
    const double square_metres = metres(r.area.a1 - r.area.a0) * metres(r.area.b1 - r.area.b0);
    result_.lamps.push_back({r.name, r.area, z, weight * square_metres, 0});
  }

  // An opening from room a's wall `side` into the first of `others` that it fits: `width` wide,
  // about `middle` or as near as holes and corners let it. False if there is no room for it.
  bool try_to_open(const std::string& name, int a, Side side, const std::vector<int>& others,
                   int middle, const Rect& size, bool sill) {
    constexpr int kStep = 50, kMargin = 100;
    Plan& plan = result_.plan;
    const int reach = plan.room(a).wall(side).a1 - plan.room(a).wall(side).a0;
    for (int step = 0; step <= 2 * reach / kStep; ++step) {
      const int at = middle + (step % 2 ? 1 : -1) * ((step + 1) / 2) * kStep;
      const Rect rect{at + size.a0, at + size.a1, size.b0, size.b1};
      const Rect framed = rect.grown(kFrameWidth + kMargin);
      for (int b : others) {
        if (!fits(plan.room(a), side, framed) || !fits(plan.room(b), opposite(side), framed))
          continue;
        plan.add(Opening{.name = name,
                         .a = a,
                         .b = b,
                         .side = side,
                         .rect = rect,
                         .reveal = p_.reveal,
                         .frame = {.width = kFrameWidth, .sill = sill, .paint = p_.frame}});
        return true;
      }
    }
    return false;
  }
  void open(const std::string& name, int a, Side side, const std::vector<int>& others, int middle,
            const Rect& size, bool sill) {
    ATRIUM_CHECK(try_to_open(name, a, side, others, middle, size, sill));
  }
  static bool fits(const Room& room, Side side, const Rect& framed) {
    const Rect wall = room.wall(side);
    return wall.a0 <= framed.a0 && framed.a1 <= wall.a1 &&
           std::ranges::none_of(room.holes_in(side),
                                [&](const WallHole& h) { return h.framed.overlaps(framed); });
  }
  static Rect hole(int width, int z, int bottom, int top) {
    return {-width / 2, width / 2, z + bottom, z + top};
  }
  static Rect door(int z) { return hole(kDoorWidth, z, 0, kDoorHeight); }

  void plan_storey(int level) {
    levels_.push_back({});
    const int z = level * kStoreyPitch;
    plan_corridors(level, z);
    plan_offices(level, z, Side::kSouth);
    plan_offices(level, z, Side::kNorth);
    plan_core(level, z);
  }

  void plan_corridors(int level, int z) {
    const int length = length_of(options_.offices), count = segments_of(options_.offices);
    Plan& plan = result_.plan;
    const std::string name = storey_name(level);
    Level& here = levels_.back();
    const auto add = [&](const std::string& tail, const Rect& area) {
      const int room = add_room(name + tail, Use::kCorridor, area, z, kStoreyHeight);
      add_zone(room, z + kLampHeight, kCorridorWeight);
      return room;
    };
    for (int s = 0; s < count; ++s) {
      // Fire doors stand where a partition between offices stands.
      const auto border = [&](int i) {
        return i * options_.offices / count * (kOfficeWidth + kWall);
      };
      const int x0 = border(s), x1 = s + 1 == count ? length : border(s + 1) - kWall;
      const std::string tail = std::to_string(s + 1);
      here.south.push_back(
          add("corridor_south" + tail, {x0, x1, kSouthCorridor, kSouthCorridor + kCorridorWidth}));
      here.north.push_back(
          add("corridor_north" + tail, {x0, x1, kNorthCorridor, kNorthCorridor + kCorridorWidth}));
    }
    const Rect passage = hole(kPassageWidth, z, 0, kPassageHeight);
    for (int s = 0; s + 1 < count; ++s) {
      for (const auto* row : {&here.south, &here.north}) {
        const auto i = static_cast<std::size_t>(s);
        const Rect& a = plan.room((*row)[i]).area;
        open("passage" + std::to_string(s + 1), (*row)[i], Side::kEast, {(*row)[i + 1]},
             (a.b0 + a.b1) / 2, passage, false);
      }
    }
    for (const bool west : {true, false}) {
      const int x0 = west ? 0 : length - kCorridorWidth;
      const std::string tail = west ? "corridor_west" : "corridor_east";
      const int room = add(tail, {x0, x0 + kCorridorWidth, kCore, kCore + kCoreDepth});
      const int middle = x_ + x0 + kCorridorWidth / 2;
      open(tail + "_south", room, Side::kSouth, here.south, middle, passage, false);
      open(tail + "_north", room, Side::kNorth, here.north, middle, passage, false);
      const int y = y_ + kCore + kCoreDepth / 2;
      plan.add(window(p_, "window", room, west ? Side::kWest : Side::kEast, y - kWindowWidth / 2,
                      y + kWindowWidth / 2, z));
    }
  }

  void plan_offices(int level, int z, Side row) {
    const bool south = row == Side::kSouth;
    const Level& here = levels_.back();
    Dice walls(options_.seed, south ? "partitions south" : "partitions north");
    Dice doors(options_.seed, storey_name(level) + (south ? "doors south" : "doors north"));
    const int y = south ? 0 : kNorthOffices;
    int x = 0;
    for (int i = 0; i < options_.offices; ++i) {
      const int nominal = (i + 1) * (kOfficeWidth + kWall) - kWall;
      const bool free = i + 1 < options_.offices && !under_fire_door(i + 1);
      constexpr int kStep = 50;
      const int move = walls.integer(-kPartitionMove / kStep, kPartitionMove / kStep) * kStep;
      const int end = nominal + (free ? move : 0);
      const int number = (south ? 100 : 200) + i + 1;
      const std::string tail = "office" + std::to_string(number);
      const int room = add_room(storey_name(level) + tail, Use::kOffice,
                                {x, end, y, y + kOfficeDepth}, z, kStoreyHeight);
      add_zone(room, z + kLampHeight, 1);
      const int middle = x_ + (x + end) / 2;
      const int at = x_ + (doors.integer(0, 1) ? x + 700 : end - 700);
      open("door_" + tail, room, opposite(row), south ? here.south : here.north, at, door(z),
           false);
      const int a0 = middle - kWindowWidth / 2, a1 = middle + kWindowWidth / 2;
      result_.plan.add(window(p_, "window", room, row, a0, a1, z));
      add_radiator(room, row, a0, a1);
      add_board_and_diffuser(room, 1500, 3500);
      x = end + kWall;
    }
  }
  bool under_fire_door(int office) const {
    const int count = segments_of(options_.offices);
    for (int s = 1; s < count; ++s)
      if (s * options_.offices / count == office) return true;
    return false;
  }
  // A board on the west wall, from `from` to `to` off its south end, and a diffuser in the ceiling.
  void add_board_and_diffuser(int index, int from, int to) {
    constexpr int kDiffuser = 600, kBottom = 900, kTop = 2000;
    Room& room = result_.plan.room(index);
    const int x = (room.area.a0 + room.area.a1) / 2, y = (room.area.b0 + room.area.b1) / 2;
    room.ceiling_panels.push_back(Rect{x, x, y, y}.grown(kDiffuser / 2));
    room.ceiling_panel = p_.grille;
    const int south = room.area.b0;
    result_.plan.add(Panel{"board",
                           index,
                           Side::kWest,
                           {south + from, south + to, room.z0 + kBottom, room.z0 + kTop},
                           p_.board});
  }
  void add_radiator(int room, Side side, int a0, int a1) {
    result_.radiators.push_back({"radiator", room, side, a0, a1});
    claim_floor(result_.plan, result_.radiators.back());
  }

  void plan_core(int level, int z) {
    int classrooms = 0, open_areas = 0, inner = 0;
    for (const CoreItem& item : items_) {
      if (item.use == Use::kClassroom)
        plan_classroom(level, z, item, "classroom" + std::to_string(++classrooms));
      if (item.use == Use::kOpen)
        plan_open_area(level, z, item, "open_area" + std::to_string(++open_areas));
      if (item.use == Use::kOffice) plan_inner_offices(level, z, item, inner);
    }
    plan_services(level, z);
  }

  int add_core_room(int level, int z, const CoreItem& item, const std::string& tail) {
    const int room = add_room(storey_name(level) + tail, item.use,
                              {item.x0, item.x1, kCore, kCore + kCoreDepth}, z, kStoreyHeight);
    add_zone(room, z + kLampHeight, 1);
    return room;
  }

  void plan_classroom(int level, int z, const CoreItem& item, const std::string& tail) {
    const int room = add_core_room(level, z, item, tail);
    open_both_ways("door_" + tail, room, {middle_of(item)}, door(z), false, level);
    add_board_and_diffuser(room, 2500, 6500);
  }

  void plan_open_area(int level, int z, const CoreItem& item, const std::string& tail) {
    constexpr int kColumns = 2, kFromMiddle = 2600, kColumnSpace = 520, kColumnSides = 8;
    constexpr double kColumnRadius = .25;
    const int room = add_core_room(level, z, item, tail);
    open_both_ways("opening_" + tail, room, {middle_of(item)},
                   hole(kWideOpening, z, 0, kWideHeight), false, level);
    for (int c = 0; c < kColumns; ++c) {
      const int x = middle_of(item) + (c ? kFromMiddle : -kFromMiddle);
      const int y = y_ + kCore + kCoreDepth / 2;
      result_.columns.push_back({"column" + std::to_string(c + 1),
                                 room,
                                 {metres(x), metres(y)},
                                 kColumnSides,
                                 kColumnRadius});
      result_.plan.room(room).occupied.push_back(Rect{x, x, y, y}.grown(kColumnSpace / 2));
    }
  }
  int middle_of(const CoreItem& item) const { return x_ + (item.x0 + item.x1) / 2; }

  void plan_inner_offices(int level, int z, const CoreItem& item, int& number) {
    constexpr int kColumns = 3, kRow = (kCoreDepth - kWall) / 2;
    const Level& here = levels_.back();
    const int width = (item.x1 - item.x0 + kWall) / kColumns - kWall;
    for (const bool south : {true, false}) {
      const int y = south ? kCore : kCore + kRow + kWall;
      for (int c = 0; c < kColumns; ++c) {
        const int x0 = item.x0 + c * (width + kWall);
        const int x1 = c + 1 == kColumns ? item.x1 : x0 + width;
        const std::string tail = "inner" + std::to_string(++number);
        const int room = add_room(storey_name(level) + tail, Use::kOffice, {x0, x1, y, y + kRow}, z,
                                  kStoreyHeight);
        add_zone(room, z + kLampHeight, 1);
        open("door_" + tail, room, south ? Side::kSouth : Side::kNorth,
             south ? here.south : here.north, x_ + x0 + 800, door(z), false);
        add_board_and_diffuser(room, 1500, 3200);
      }
    }
  }

  // Behind the stairwells, with doors to the north corridor.
  void plan_services(int level, int z) {
    const int x = kCorridorWidth + kWall;
    const int y0 = kCore + kStairLength + kWall;
    for (const bool west : {true, false}) {
      const int x0 = west ? x : length_of(options_.offices) - x - kStairWidth;
      const std::string tail = west ? "service_west" : "service_east";
      const int room = add_room(storey_name(level) + tail, Use::kService,
                                {x0, x0 + kStairWidth, y0, kCore + kCoreDepth}, z, kStoreyHeight);
      add_zone(room, z + kLampHeight, 1);
      open("door_" + tail, room, Side::kNorth, levels_.back().north, x_ + x0 + kStairWidth / 2,
           door(z), false);
    }
  }

  // To the south and the north corridor at each of `middles`; but for the first, where they fit:
  // a fire door's wall may stand in the way.
  void open_both_ways(const std::string& name, int room, const std::vector<int>& middles,
                      const Rect& size, bool sill, int level) {
    const Level& here = levels_[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < middles.size(); ++i) {
      const std::string number = std::to_string(i + 1);
      for (const bool south : {true, false}) {
        const bool opened = try_to_open(name + (south ? "_south" : "_north") + number, room,
                                        south ? Side::kSouth : Side::kNorth,
                                        south ? here.south : here.north, middles[i], size, sill);
        ATRIUM_CHECK(opened || i > 0);
      }
    }
  }

  void plan_atrium(const CoreItem& item) {
    const int top = (options_.storeys - 1) * kStoreyPitch + kStoreyHeight;
    const int room = add_room(options_.name + "atrium", Use::kAtrium,
                              {item.x0, item.x1, kCore, kCore + kCoreDepth}, 0, top);
    const int middle = middle_of(item);
    for (int level = 0; level < options_.storeys; ++level) {
      const int z = level * kStoreyPitch;
      const std::string name = "opening_floor" + std::to_string(level + 1);
      const std::vector<int> middles{middle - kGalleryPitch, middle, middle + kGalleryPitch};
      const bool gallery = level > 0;  // with a parapet; one storey's openings stand over another's
      open_both_ways(name, room, middles,
                     gallery ? hole(kWideOpening, z, kGallerySill, kGalleryHead)
                             : hole(kWideOpening, z, 0, kWideHeight),
                     gallery, level);
      add_zone(room, z + kLampHeight, kAtriumWeight);
      result_.lamps.back().name += "/level" + std::to_string(level + 1);
    }
  }

  void plan_stairwell(const std::string& name, int x0) {
    const int rise = options_.storeys - 1;
    const int top = rise > 0 ? rise * kStoreyPitch + kStoreyHeight : kStairLampNorth + 600;
    const int room = add_room(options_.name + name, Use::kStairs,
                              {x0, x0 + kStairWidth, kCore, kCore + kStairLength}, 0, top);
    result_.stairwells.push_back(room);
    const Rect area = result_.plan.room(room).area;
    const int middle = (area.a0 + area.a1) / 2;
    for (int level = 0; level < options_.storeys; ++level) {
      const int z = level * kStoreyPitch;
      const Level& here = levels_[static_cast<std::size_t>(level)];
      open("door_" + name + std::to_string(level + 1), room, Side::kSouth, here.south, middle,
           door(z), false);
      const std::string lamp = options_.name + name + "/level" + std::to_string(level + 1);
      result_.lamps.push_back(
          {lamp, {area.a0, area.a1, area.b0, area.b0 + 500}, z + kStairLampSouth, 0, 1});
      if (z + kStairLampNorth < top)
        result_.lamps.push_back({lamp + "_half",
                                 {area.a0, area.a1, area.b1 - 500, area.b1},
                                 z + kStairLampNorth,
                                 0,
                                 1});
      // Over the door, in the corridor that it opens to.
      result_.signs.push_back(
          {storey_name(level) + "lamp_exit_" + name,
           {metres(middle), metres(area.b0 - kWall) - .06, metres(z + kSignHeight)},
           Side::kSouth});
    }
  }

  const StoreyOptions options_;
  const Palette& p_;
  const std::vector<CoreItem> items_;
  const int x_, y_;
  std::vector<Level> levels_;
  Storeys result_;
};

int rooms_of(int offices) {
  int rooms =
      2 * offices + 2 * segments_of(offices) + 2 + 2 + 2;  // cross corridors, services, stairs
  for (const CoreItem& item : core_items(offices)) rooms += item.use == Use::kOffice ? 6 : 1;
  return rooms;
}

}  // namespace

Storeys plan_storeys(const StoreyOptions& options, const Palette& p) {
  return StoreyPlanner(options, p).plan();
}

double building_length(int offices) { return metres(length_of(offices)); }

int offices_for(int rooms) {
  constexpr int kLeast = 6;  // a core with one room between the stairwells
  int offices = kLeast;
  while (rooms_of(offices) < rooms) ++offices;
  return offices;
}

}  // namespace atrium::generator
