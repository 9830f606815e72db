// validate stiffness: complete gathers, all levels of refinement together, until the relative
// residual is 1e-6, where ever more of the light is reflected; and whether all of it is there then.
// What plain Gauss-Seidel takes grows as 1/(1-ρ): some 60 gathers at ρ = .9, and over 300 beyond.
#include <array>
#include <cstdio>

#include "apps/validation/solved_scene.h"
#include "apps/validation/suites.h"
#include "apps/validation/test_rooms.h"

namespace atrium {
namespace {

constexpr double kError = 0.02, kResidual = 1e-6;
constexpr std::uint64_t kMostGathers = 100;  // beyond it has failed, and takes time

struct Rung {
  double reflectance;
  double most_gathers;
};
constexpr std::array<Rung, 4> kLadder{{{.9, 12}, {.99, 14}, {.999, 12}, {.99999, 8}}};

struct StiffScene {
  const char* name;
  Result<GeneratedModel> (*make)(double reflectance);
};

// CIE 171:2006, 5.8.
Result<GeneratedModel> cube(double reflectance) {
  const Vec3 size{4, 4, 4};
  return lamp_lit_room(reflectance, size, middle_of(size, 1), 10000);
}
Result<GeneratedModel> cornell(double reflectance) {
  return furnished_room("cornell", reflectance);
}
Result<GeneratedModel> one_of_rooms(double reflectance) {
  return furnished_room("rooms", reflectance);
}
constexpr std::array<StiffScene, 3> kScenes{
    {{"cube", cube}, {"cornell", cornell}, {"rooms", one_of_rooms}}};

Status judge_rung(const StiffScene& scene, const Rung& rung, int basis, Validation& v) {
  char name[64];
  std::snprintf(name, sizeof name, "%s, rho %.5g", scene.name, rung.reflectance);
  const Result<GeneratedModel> model = scene.make(rung.reflectance);
  if (!model.ok()) return model.status();
  SolveOptions asked = asking(kError, basis);
  asked.residual = kResidual;
  asked.iterations = kMostGathers;
  const auto solved = SolvedScene::make(*model, asked);
  if (!solved.ok()) return note_unsolved(name, solved.status(), v);
  const SolveSummary& summary = (*solved)->summary();
  const bool reached = summary.exit_code == 0 && summary.residual <= kResidual;
  const double gathers = double(summary.iterations);
  v.cases.push_back(at_most(std::string(name) + ": gathers", rung.most_gathers, gathers));
  if (!reached) v.cases.back().pass = false;  // however soon it gave up
  note_end(name, summary, v);
  const Result<Totals> sum = (*solved)->totals();
  if (!sum.ok()) return sum.status();
  const double leaving = flux_of(*model) / (1 - rung.reflectance);
  v.cases.push_back(
      within(std::string(name) + ": leaving, lm", leaving, sum->leaving, kError * leaving));
  return {};
}

}  // namespace

Result<Validation> judge_stiffness(int basis) {
  Validation v;
  for (const StiffScene& scene : kScenes)
    for (const Rung& rung : kLadder) ATRIUM_RETURN_IF_ERROR(judge_rung(scene, rung, basis, v));
  return v;
}

}  // namespace atrium
