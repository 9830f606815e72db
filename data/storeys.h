// The building's plan: storeys of offices along two corridors about a core of stairwells,
// classrooms, an open area, blocks of inner offices and an atrium that rises through all of them.
//
//      offices   offices   offices …              north
//      corridor  |  corridor  |  …
//      c stairs | class | inner | atrium | open | inner | stairs c      c: cross corridors
//      corridor  |  corridor  |  …
//      offices   offices   offices …              south
//
// Storeys are alike but for the seed's moves of doors. All in whole millimetres.
#pragma once

#include <string>
#include <vector>

#include "data/fittings.h"
#include "data/stairs.h"

namespace atrium::generator {

inline constexpr int kPaperOffices = 20;  // along each corridor, in the models of Table 3
inline constexpr int kPaperStoreys = 5;

struct StoreyOptions {
  std::string name = {};        // prefix of all names, "" or "building2/"
  int offices = kPaperOffices;  // along each corridor
  int storeys = 1;
  Vec2 origin{0};  // m, of the south-west corner
  std::uint64_t seed = 1;
};

enum class Use { kOffice, kCorridor, kClassroom, kOpen, kService, kAtrium, kStairs };

// Where lamps hang: over an area at a height, shared out with the other zones by weight.
struct LampZone {
  std::string name;
  Rect area;  // mm
  int z = 0;  // mm, of the lamps' tops
  double weight = 0;
  int fixed = 0;  // so many, whatever the weight
};

struct Sign {
  std::string name;
  Vec3 center{0};
  Side side = Side::kWest;
};

struct Storeys {
  Plan plan;
  std::vector<Use> uses;  // of the plan's rooms
  std::vector<Radiator> radiators;
  std::vector<Pipe> columns;
  std::vector<LampZone> lamps;
  std::vector<Sign> signs;  // where signs may hang, the most needed first
  std::vector<int> stairwells;
  int storeys = 1;
};

Storeys plan_storeys(const StoreyOptions& options, const Palette& p);

// The least number of offices along a corridor that gives a storey so many rooms.
int offices_for(int rooms);

double building_length(int offices);  // m, west to east

}  // namespace atrium::generator
