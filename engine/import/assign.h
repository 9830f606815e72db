// The file of --assign: materials and lights given by name, for models that come without lamps,
// and objects left out. TOML:
//   [[material]]  match = "glob"   over material names or object names
//                 reflectance, emission (cd/m²): one number or three; sides: 1 or 2
//   [[object]]    match = "glob", drop = true
// Rules apply in the file's order, later ones over earlier ones. An unknown key is an error.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/status.h"

namespace atrium {

struct MaterialRule {
  std::string match;
  std::optional<Spectrum> reflectance;  // in [0, 1]
  std::optional<Spectrum> emission;     // cd/m², not negative
  std::optional<Sides> sides;
};

struct Assignment {
  std::string file;
  std::vector<MaterialRule> materials;
  std::vector<std::string> dropped_objects;  // globs
};

Result<Assignment> read_assignment(const std::string& path);

// Applies the material rules to the model. Faces whose object a rule matches get materials of
// their own, named "material [object glob]"; rules that match nothing are warned of.
void assign_materials(const Assignment& assignment, RawModel& model, WarningLog& warnings);

bool glob_matches(const std::string& glob, const std::string& name);

}  // namespace atrium
