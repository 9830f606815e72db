// MTL material libraries: Kd, Ke, d or Tr, and whether textures were named. Strict, like the OBJ
// reader; what else a library says (Ks, Ni, illum, ...) is not diffuse and is passed over.
#pragma once

#include <string>
#include <unordered_map>

#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/status.h"

namespace atrium {

// Appends the library's materials and enters them into `by_name`; a later definition of a name
// replaces the earlier one.
Status read_mtl(const std::string& path, std::uint32_t file, RawModel& model,
                std::unordered_map<std::string, std::uint32_t>& by_name, WarningLog& warnings);

// A material that a face names and no library defines: without a reflectance.
RawMaterial undefined_material(std::string name, std::uint32_t file);

}  // namespace atrium
