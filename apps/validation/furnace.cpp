// validate furnace: in a closed scene whose surfaces all have the reflectance ρ and the exitance M,
// every point's radiosity is M/(1-ρ). Rows of form factors that are closed by force pass that
// whatever is in them, so rooms of one ρ that a lamp lights are judged too: all of Φ is absorbed
// there, and Φ/(1-ρ) leaves the surfaces.
#include <string>

#include "apps/validation/solved_scene.h"
#include "apps/validation/suites.h"
#include "apps/validation/test_rooms.h"

namespace atrium {
namespace {

constexpr double kExitance = 100;  // lm/m²
// What is asked of either sets how finely they are cut.
constexpr double kFurnaceError = 0.05;
constexpr double kResidual = 1e-5;   // a tenth of what is allowed
constexpr double kDeviation = 1e-4;  // relative
constexpr double kLampLitError = 0.05;
// Sweeps without any acceleration come to the residual at ρ = .999 in some 6,100, and lamp-lit
// rooms to an end in as many.
constexpr std::uint64_t kMostGathers = 8000;

// The largest relative deviation from `radiosity` at the corners of elements.
Result<double> worst_deviation(SolvedScene& scene, double radiosity) {
  double worst = 0;
  ATRIUM_RETURN_IF_ERROR(
      scene.solution().for_each_cluster([&](ClusterId, const ClusterView& cluster) {
        for (std::size_t p = 0; p < cluster.size(); ++p) {
          const PatchView tree = cluster.patch(p);
          if (tree.head->inert) continue;
          for (std::size_t i = 0; i < tree.elements.size(); ++i) {
            if (!tree.elements[i].leaf()) continue;
            for (const Vec2& corner : tree.polygon(tree.elements[i])) {
              const Spectrum e = irradiance_at(tree, static_cast<std::int32_t>(i), corner);
              const Spectrum b = tree.head->exitance + tree.head->reflectance * e;
              for (int c = 0; c < kChannels; ++c)
                worst = worse(worst, std::abs(b[c] / radiosity - 1));
            }
          }
        }
      }));
  return worst;
}

std::string titled(const std::string& scene, double rho, int basis) {
  std::string digits = std::to_string(rho);
  digits.erase(digits.find_last_not_of('0') + 1);
  return scene + ", rho " + digits + ", basis " + std::to_string(basis);
}

}  // namespace

Status judge_furnace(const std::string& name, const GeneratedModel& model, double radiosity,
                     int basis, Validation& v) {
  SolveOptions asked = asking(kFurnaceError, basis);
  asked.residual = kResidual;
  asked.iterations = kMostGathers;
  const auto scene = SolvedScene::make(model, asked);
  if (!scene.ok()) return note_unsolved(name, scene.status(), v);
  note_end(name, (*scene)->summary(), v);
  const Result<double> worst = worst_deviation(**scene, radiosity);
  if (!worst.ok()) return worst.status();
  v.cases.push_back(within(name, 0, *worst, kDeviation));
  return {};
}

Status judge_lamp_lit(const std::string& name, const GeneratedModel& model, double reflectance,
                      int basis, Validation& v) {
  SolveOptions asked = asking(kLampLitError, basis);
  asked.iterations = kMostGathers;
  const auto scene = SolvedScene::make(model, asked);
  if (!scene.ok()) return note_unsolved(name, scene.status(), v);
  note_end(name, (*scene)->summary(), v);
  const Result<Totals> sum = (*scene)->totals();
  if (!sum.ok()) return sum.status();
  const double flux = flux_of(model), leaving = flux / (1 - reflectance);
  v.cases.push_back(within(name + ": absorbed", flux, sum->absorbed, kLampLitError * flux));
  v.cases.push_back(within(name + ": leaving", leaving, sum->leaving, kLampLitError * leaving));
  return {};
}

Result<Validation> judge_furnaces(const FurnaceChoice& choice) {
  Validation v;
  for (const int basis : choice.bases)
    for (const double rho : choice.reflectances) {
      for (const std::string& shape : choice.shapes) {
        const Result<GeneratedModel> model =
            generate({.kind = "furnace", .rho = rho, .exitance = kExitance, .shape = shape});
        if (!model.ok()) return model.status();
        ATRIUM_RETURN_IF_ERROR(
            judge_furnace(titled(shape, rho, basis), *model, kExitance / (1 - rho), basis, v));
      }
      for (const char* kind : {"cornell", "rooms"}) {
        const Result<GeneratedModel> model = furnished_room(kind, rho);
        if (!model.ok()) return model.status();
        ATRIUM_RETURN_IF_ERROR(judge_lamp_lit(titled(kind, rho, basis), *model, rho, basis, v));
      }
    }
  return v;
}

}  // namespace atrium
