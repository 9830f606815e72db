// glTF 2.0, .gltf and .glb: triangles of all nodes with their transforms; a node with a mesh is an
// object. No images are loaded. Light: emissiveFactor × KHR_materials_emissive_strength in cd/m².
#pragma once

#include <string>

#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/status.h"

namespace atrium {

Status read_gltf(const std::string& path, RawModel& model, WarningLog& warnings);

}  // namespace atrium
