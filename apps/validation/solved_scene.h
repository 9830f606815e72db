// SolvedScene: a small scene through the whole solve, for the suites of `atrium validate`: written
// as OBJ to a temporary directory, solved to a run beside it, and probed. All of it is gone when
// the object is.
//
// Not thread safe: one caller at a time.
#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "apps/validation.h"
#include "data/generate.h"
#include "scheduler/solution.h"
#include "scheduler/solve.h"

namespace atrium {

// A point of a surface in the scene's own frame and units; the normal says which side is meant.
struct SurfaceProbe {
  Vec3 x{0}, normal{0};
};

// What is asked of a solve.
inline SolveOptions asking(double error, int basis) {
  SolveOptions options;
  options.error = error;
  options.basis = basis;
  return options;
}

// Sums over all surfaces that receive light, luminance.
struct Totals {
  double arrived = 0;   // lm: ∫ E
  double leaving = 0;   // lm: ∫ B
  double absorbed = 0;  // lm: ∫ (1-ρ) E
};

class SolvedScene {
 public:
  // The front of every surface counts, and its back is black, as the generator means it.
  // `asked` says what is asked of the solve; its scene and run directory are set here.
  // assign: the text of an --assign file; "" for none. Errors are the solve's.
  static Result<std::unique_ptr<SolvedScene>> make(const GeneratedModel& model, SolveOptions asked,
                                                   const std::string& assign = "");
  ~SolvedScene();
  SolvedScene(const SolvedScene&) = delete;
  SolvedScene& operator=(const SolvedScene&) = delete;

  const SolveSummary& summary() const;
  Solution& solution();

  // What stands at a point; none where no surface is.
  Result<std::optional<SurfaceSample>> at(const SurfaceProbe& probe);
  Result<Totals> totals();

 private:
  struct Parts;
  explicit SolvedScene(std::unique_ptr<Parts> parts);
  std::unique_ptr<Parts> parts_;
};

// The larger one; what is not a number is worse than all.
inline double worse(double a, double b) { return std::isnan(a) || a > b ? a : b; }

// Notes that a scene could not be solved: a case that fails, and why. The disk's own failures stay
// errors.
Status note_unsolved(const std::string& name, const Status& why, Validation& v);

// Says of a solve that did not come to what was asked of it why it ended.
void note_end(const std::string& name, const SolveSummary& summary, Validation& v);

// E's luminance at a point, in lx, against what is expected there; a point on no surface fails.
Status judge_illuminance(const std::string& name, SolvedScene& scene, const SurfaceProbe& probe,
                         double expected, double allowed, Validation& v);

// `count` points on a model's faces, uniform by area, the same for the same model.
std::vector<SurfaceProbe> points_by_area(const GeneratedModel& model, int count);

}  // namespace atrium
