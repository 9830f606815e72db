// The generator: procedural closed interiors, from a Cornell-like room to the five models of the
// paper's Tables 2 and 3 and beyond. [THFH94 §5.3, §7]
//
// What holds for every model:
//  1. Metres, z up. Groups come in a modeller's order: walls, floors and ceilings room by room,
//  then
//     lamps, then furniture; names carry the hierarchy ("floor2/office14/wall_north").
//  2. Faces are planar and convex, counter-clockwise seen from the lit air. There is no outer
//  shell:
//     no ray from any face's front escapes.
//  3. No two faces overlap in one plane, and no two of a group could be rejoined: none that are
//     coplanar, of one material and share a part of an edge have a convex union.
//  4. The same options give the same model, bit for bit.
// Functions are pure; safe from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "data/generated_model.h"
#include "engine/status.h"

namespace atrium {

// An option that is left empty takes the kind's default; one that the kind does not know is
// refused.
struct GenerateOptions {
  std::string kind;                       // one of generator_kinds()
  std::uint64_t seed = 1;                 // moves furniture, partitions and colours about
  std::optional<double> rho = {};         // furnace, rooms: every surface's reflectance, in [0, 1)
  std::optional<double> exitance = {};    // furnace: every surface's M, lm/m²
  std::optional<std::string> shape = {};  // furnace: cube, l-room, two-rooms or grid3x3
  std::optional<int> grid = {};           // rooms: K of K×K
  std::optional<std::string> furnish = {};  // offices, floor, building, campus: none, low or high
  std::optional<int> storeys = {};          // building, campus
  std::optional<int> rooms = {};            // floor, building, campus: at least so many on a storey
  std::optional<int> buildings = {};        // campus
};

const std::vector<std::string>& generator_kinds();

Result<GeneratedModel> generate(const GenerateOptions& options);

// Writes the model as OBJ to `path` and its materials beside it, to the same name with ".mtl".
// Ke is luminance in cd/m². Numbers read back as the same doubles. There is no writing to stdout:
// an OBJ without its materials has no light.
Status write_obj(const GeneratedModel& model, const std::string& path);

}  // namespace atrium
