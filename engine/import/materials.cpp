#include "engine/import/materials.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/quantity.h"

namespace atrium {
namespace {

constexpr double kDefaultReflectance = 0.5;
// Below this the brightest lamp of a scene was hardly meant in cd/m²: assets often mean "1 =
// white".
constexpr double kDimLuminance = 100;

std::string quoted(const RawModel& model, const RawMaterial& m) {
  return "'" + m.name + "' of " + model.files[m.file];
}

Status refused(const RawModel& model, const RawMaterial& m, const std::string& cause,
               const std::string& remedy) {
  const std::string file = m.library.empty() ? model.files[m.file] : m.library;
  std::string place = m.place + (m.place.empty() ? "" : ", ") + "material '" + m.name + "'";
  return Status(Code::kScene, file, place, cause, remedy);
}

// %g of each channel, for messages.
std::string written(const Spectrum& s) {
  const auto number = [](double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", x);
    return std::string(text);
  };
  return number(s.x) + " " + number(s.y) + " " + number(s.z);
}

Status check(const RawModel& model, const RawMaterial& m) {
  for (int k = 0; k < 3; ++k) {
    const double r = m.reflectance[k], e = m.emission[k];
    if (m.has_reflectance && !(r >= 0 && r <= 1))
      return refused(model, m, "reflectance " + written(m.reflectance) + " is not within 0..1",
                     "no surface reflects more than it receives: correct it or --assign another");
    if (!(e >= 0 && std::isfinite(e)))
      return refused(model, m, "emission " + written(m.emission) + " is not a number of 0 or more",
                     "correct it or --assign another");
  }
  return {};
}

Spectrum reflectance_of(const RawMaterial& m) {
  if (m.has_reflectance) return m.reflectance;
  return m.emission == Spectrum{0} ? Spectrum{kDefaultReflectance} : Spectrum{0};
}

void warn(const RawModel& model, const RawMaterial& m, const ImportOptions& options,
          WarningLog& warnings) {
  const std::string name = quoted(model, m);
  if (is_clear(m)) {
    warnings.add("clear glass left out", name);
    if (m.emission != Spectrum{0}) warnings.add("clear glass that would emit left out", name);
    return;
  }
  if (!m.has_reflectance)
    warnings.add("materials without a reflectance: lamps taken as 0, others as 0.5", name);
  if (m.reflectance.x == 1 || m.reflectance.y == 1 || m.reflectance.z == 1) {
    char what[80];
    std::snprintf(what, sizeof what, "reflectance of exactly 1 (white paint) taken as %g",
                  options.white);
    warnings.add(what, name);
  }
  if (m.textured) warnings.add("textures ignored, the flat colour counts", name);
}

}  // namespace

void default_materials(RawModel& model, WarningLog& warnings) {
  std::uint32_t index = RawFace::kNoMaterial;
  for (RawFace& f : model.faces) {
    if (f.material != RawFace::kNoMaterial) continue;
    if (index == RawFace::kNoMaterial) {
      index = static_cast<std::uint32_t>(model.materials.size());
      RawMaterial m;
      m.name = "default";
      m.file = model.objects[f.object].file;
      m.reflectance = Spectrum{kDefaultReflectance};
      m.has_reflectance = true;
      model.materials.push_back(m);
    }
    warnings.add("faces without a material taken as reflectance 0.5", model.describe(f));
    f.material = index;
  }
}

Result<std::vector<Material>> physical_materials(const RawModel& model,
                                                 const std::vector<bool>& used,
                                                 const ImportOptions& options,
                                                 WarningLog& warnings) {
  std::vector<Material> materials;
  double brightest = 0;  // cd/m²
  for (std::size_t i = 0; i < model.materials.size(); ++i) {
    const RawMaterial& raw = model.materials[i];
    ATRIUM_RETURN_IF_ERROR(check(model, raw));
    if (used[i]) warn(model, raw, options, warnings);
    Material m;
    m.name = raw.name;
    m.reflectance = reflectance_of(raw);
    for (int k = 0; k < 3; ++k)
      if (m.reflectance[k] == 1) m.reflectance[k] = options.white;
    const bool luminous = raw.emission_is_luminance || !options.emission_is_exitance;
    m.exitance = raw.emission * (luminous ? std::numbers::pi : 1.0);
    if (used[i] && !is_clear(raw))
      brightest = std::max(brightest, luminance(m.exitance) / std::numbers::pi);
    materials.push_back(std::move(m));
  }
  if (brightest > 0 && brightest < kDimLuminance) {
    char text[64];
    std::snprintf(text, sizeof text, "%.4g cd/m²", brightest);
    warnings.add("the brightest lamp is below 100 cd/m²: was its emission meant in other units?",
                 text);
  }
  return materials;
}

}  // namespace atrium
