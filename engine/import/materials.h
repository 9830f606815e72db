// From what the files say of materials to physical ones: reflectance in [0, 1), exitance in lm/m².
#pragma once

#include <vector>

#include "engine/import/import.h"
#include "engine/import/raw_model.h"
#include "engine/import/warning_log.h"
#include "engine/status.h"

namespace atrium {

// Alpha below this is clear glass: left out of the light's way.
inline constexpr double kClearBelow = 0.5;

inline bool is_clear(const RawMaterial& m) { return m.opacity < kClearBelow; }

// Gives faces without a material the default one.
void default_materials(RawModel& model, WarningLog& warnings);

// The model's materials by index. `used`: those that some face kept has; warnings name only them.
// Reflectances outside [0, 1], NaN and negative emissions are refused with the material's name.
Result<std::vector<Material>> physical_materials(const RawModel& model,
                                                 const std::vector<bool>& used,
                                                 const ImportOptions& options,
                                                 WarningLog& warnings);

}  // namespace atrium
