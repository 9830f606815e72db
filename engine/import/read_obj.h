// Wavefront OBJ with its MTL libraries, read strictly: every number must be one, every index must
// exist, and what is wrong is named with its line. (tinyobjloader takes `v nan abc` for zeros,
// lets indices out of range through and has no line numbers for most errors; hence our own.)
#pragma once

#include <string>

#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/status.h"

namespace atrium {

// Appends the file's faces, objects and materials. Objects are the `o` blocks, or the `g` blocks
// of a file without any `o`; consecutive blocks of one name are one object.
Status read_obj(const std::string& path, RawModel& model, WarningLog& warnings);

}  // namespace atrium
