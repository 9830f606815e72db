#include "apps/command.h"
#include "engine/quantity.h"

namespace atrium {
namespace {

struct NamedUnit {
  const char* name;
  double metres;
};
constexpr NamedUnit kUnits[] = {
    {"in", 0.0254}, {"ft", 0.3048}, {"mm", 0.001}, {"cm", 0.01}, {"m", 1}};

Status set_unit(const std::string& text, double& metres) {
  for (const NamedUnit& u : kUnits)
    if (text == u.name) {
      metres = u.metres;
      return {};
    }
  const Result<double> length = parse_length(text);
  if (!length.ok() || *length == 0)
    return usage_error("there is no unit '" + text + "'",
                       "it is one of in, ft, mm, cm, m, or a length: 10cm");
  metres = *length;
  return {};
}

Status set_sides(const std::string& text, SidesChoice& sides) {
  if (text == "auto") return sides = SidesChoice::kAuto, Status();
  if (text == "one") return sides = SidesChoice::kOne, Status();
  if (text == "two") return sides = SidesChoice::kTwo, Status();
  return usage_error("there is no '" + text + "'", "it is one of auto, one, two");
}

Status set_emission(const std::string& text, bool& is_exitance) {
  if (text == "luminance") return is_exitance = false, Status();
  if (text == "exitance") return is_exitance = true, Status();
  return usage_error("there is no '" + text + "'", "it is one of luminance, exitance");
}

constexpr double kWhitest = 0.999999;  // a reflectance stays below 1

}  // namespace

void add_scene_options(OptionSet& options, ImportOptions& scene) {
  options.text("assign", "materials and lights by name, from a TOML file", scene.assign_file);
  options.text_list("drop", "leave out objects whose name matches this regular expression",
                    scene.drop);
  options.custom("sides", "which sides receive, reflect and emit (auto, one, two)", "NAME",
                 [&scene](const std::string& t) { return set_sides(t, scene.sides); });
  options.custom("unit", "what one unit of the scene is (in, ft, mm, cm, m, or a length)", "NAME",
                 [&scene](const std::string& t) { return set_unit(t, scene.unit); });
  options.custom(
      "emission", "emission is luminance in cd/m2, or exitance in lm/m2 (luminance, exitance)",
      "NAME",
      [&scene](const std::string& t) { return set_emission(t, scene.emission_is_exitance); });
  options.number("white", "what a reflectance of exactly 1 is taken as", 0, kWhitest, scene.white);
}

void add_partition_options(OptionSet& options, PartitionOptions& partition) {
  options.length("close-gaps", "openings up to this wide count as closed; each is reported (0)",
                 partition.close_gaps);
}

}  // namespace atrium
