// How the tests of links refine and gather where they do not ask for something else.
#pragma once

#include "solver/refine.h"

namespace atrium::testing {

inline constexpr double kNoCap = 1e30;  // lm/m²: no source is brighter

inline RefineSettings settings_of(double threshold) {
  RefineSettings s;
  s.threshold = threshold;
  s.min_edge = 0.002;
  s.tolerance = 1e-6;
  return s;
}

}  // namespace atrium::testing
