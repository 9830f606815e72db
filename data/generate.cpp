#include "data/generate.h"

#include <algorithm>
#include <cmath>

#include "data/building.h"
#include "data/office.h"
#include "data/simple.h"
#include "data/storeys.h"

namespace atrium {
namespace {

using namespace generator;  // what the kinds are made of

constexpr int kMostRooms = 100;  // --grid K
constexpr int kMostStoreys = 200;
constexpr int kMostBuildings = 1000, kMostRoomsOfStorey = 10000;

// A model is held in memory whole, about 120 bytes a face.
constexpr double kMostFaces = 40e6;
constexpr double kFacesOfRoom = 130, kFacesOfRoomLow = 850, kFacesOfRoomHigh = 2300;  // about
constexpr int kPaperRooms = 64;                                                       // of a storey

struct Kind {
  std::string name;
  std::vector<std::string> options;  // what it takes besides the seed
  Result<GeneratedModel> (*make)(const GenerateOptions&);
};

Status usage(const std::string& cause, const std::string& remedy) {
  return {Code::kUsage, "gen", "", cause, remedy};
}

Furnish furnish_of(const GenerateOptions& o) {
  const std::string grade = o.furnish.value_or("none");
  return grade == "low" ? Furnish::kLow : grade == "high" ? Furnish::kHigh : Furnish::kNone;
}

Result<GeneratedModel> make_building(const GenerateOptions& o) {
  const BuildingOptions b{.storeys = o.kind == "floor" ? 1 : o.storeys.value_or(kPaperStoreys),
                          .rooms = o.rooms.value_or(0),
                          .buildings = o.kind == "campus" ? o.buildings.value_or(2) : 1,
                          .furnish = furnish_of(o),
                          .seed = o.seed};
  const double rooms = static_cast<double>(o.rooms.value_or(kPaperRooms)) * b.storeys * b.buildings;
  const double each = b.furnish == Furnish::kHigh  ? kFacesOfRoomHigh
                      : b.furnish == Furnish::kLow ? kFacesOfRoomLow
                                                   : kFacesOfRoom;
  if (rooms * each > kMostFaces)
    return usage("the model would have some " + std::to_string(std::llround(rooms * each / 1e6)) +
                     " million faces, and " + std::to_string(std::llround(kMostFaces / 1e6)) +
                     " million are the most",
                 "take fewer rooms, storeys or buildings, or less furniture");
  return building(b, o.kind);
}

const std::vector<Kind>& kinds() {
  using Options = GenerateOptions;
  static const std::vector<Kind> kAll{
      {"cornell", {}, [](const Options& o) -> Result<GeneratedModel> { return cornell(o.seed); }},
      {"furnace",
       {"rho", "emit", "shape"},
       [](const Options& o) {
         return furnace(o.shape.value_or("cube"), o.rho.value_or(.5), o.exitance.value_or(100));
       }},
      {"rooms",
       {"grid", "rho"},
       [](const Options& o) -> Result<GeneratedModel> {
         return grid_of_rooms(o.grid.value_or(4), o.rho, o.seed);
       }},
      {"office",
       {"furnish"},
       [](const Options& o) -> Result<GeneratedModel> { return office(furnish_of(o), o.seed); }},
      {"office-low",
       {},
       [](const Options& o) -> Result<GeneratedModel> { return office(Furnish::kLow, o.seed); }},
      {"office-high",
       {},
       [](const Options& o) -> Result<GeneratedModel> { return office(Furnish::kHigh, o.seed); }},
      {"floor", {"furnish", "rooms"}, make_building},
      {"building", {"furnish", "storeys", "rooms"}, make_building},
      {"campus", {"furnish", "storeys", "rooms", "buildings"}, make_building},
  };
  return kAll;
}

// The options that were given, by the names they have on the command line.
std::vector<std::string> given(const GenerateOptions& o) {
  std::vector<std::string> names;
  const auto note = [&](const auto& option, const char* name) {
    if (option) names.push_back(name);
  };
  note(o.rho, "rho");
  note(o.exitance, "emit");
  note(o.shape, "shape");
  note(o.grid, "grid");
  note(o.furnish, "furnish");
  note(o.storeys, "storeys");
  note(o.rooms, "rooms");
  note(o.buildings, "buildings");
  return names;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& w : words) all += (all.empty() ? "" : ", ") + w;
  return all;
}

Status in_range(const std::optional<int>& value, int least, int most, const char* name) {
  if (!value || (*value >= least && *value <= most)) return {};
  return usage("--" + std::string(name) + " " + std::to_string(*value) + " is out of range",
               "take " + std::to_string(least) + " to " + std::to_string(most));
}

Status check_values(const GenerateOptions& o) {
  if (o.rho && !(*o.rho >= 0 && *o.rho < 1))
    return usage("--rho has to be at least 0 and below 1", "at 1 nothing would absorb the light");
  if (o.exitance && !(*o.exitance > 0 && *o.exitance <= 1e30))
    return usage("--emit has to be above 0 and finite", "it is an exitance in lm/m²");
  if (o.furnish && *o.furnish != "none" && *o.furnish != "low" && *o.furnish != "high")
    return usage("--furnish does not know \"" + *o.furnish + "\"", "take none, low or high");
  ATRIUM_RETURN_IF_ERROR(in_range(o.grid, 1, kMostRooms, "grid"));
  ATRIUM_RETURN_IF_ERROR(in_range(o.storeys, 1, kMostStoreys, "storeys"));
  ATRIUM_RETURN_IF_ERROR(in_range(o.buildings, 1, kMostBuildings, "buildings"));
  return in_range(o.rooms, 1, kMostRoomsOfStorey, "rooms");
}

}  // namespace

const std::vector<std::string>& generator_kinds() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const Kind& k : kinds()) names.push_back(k.name);
    return names;
  }();
  return kNames;
}

Result<GeneratedModel> generate(const GenerateOptions& options) {
  const auto kind = std::ranges::find(kinds(), options.kind, &Kind::name);
  if (kind == kinds().end())
    return usage("there is no kind \"" + options.kind + "\"", "take " + joined(generator_kinds()));
  for (const std::string& name : given(options)) {
    if (std::ranges::find(kind->options, name) == kind->options.end())
      return usage("--" + name + " means nothing to " + options.kind,
                   kind->options.empty() ? "it takes --seed only"
                                         : "it takes --seed, --" + joined(kind->options));
  }
  Status values = check_values(options);
  if (!values.ok()) return values;
  return kind->make(options);
}

}  // namespace atrium
