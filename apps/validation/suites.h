// The suites of `atrium validate` that bring their own scenes: analytic cases, each function one
// suite, one file each. What a suite cannot solve is a case that fails, with the reason among the
// examples; a Status is what keeps it from judging at all (no room for a temporary directory).
// They run the whole solve in temporary directories; one at a time.
#pragma once

#include <string>
#include <vector>

#include "apps/validation.h"
#include "data/generated_model.h"
#include "engine/element.h"
#include "engine/geometry.h"
#include "engine/status.h"
#include "solver/form_factor.h"

namespace atrium {

// The order of the basis that suites take where none is asked for: solve's own.
inline constexpr int kUsualBasis = 2;

// What the suite form-factors judges.
struct FormFactorMethods {
  Result<PolygonFormFactors> (*between)(PolygonView, PolygonView) = polygon_to_polygon;
  double (*from_point)(const Vec3&, const Vec3&, PolygonView) = point_to_polygon;
};
Result<Validation> judge_form_factors(const FormFactorMethods& methods);

// B = M/(1-ρ) all over a closed scene of uniform M and ρ, whatever its shape.
struct FurnaceChoice {
  std::vector<std::string> shapes{"cube", "l-room", "two-rooms", "grid3x3"};
  std::vector<double> reflectances{.5, .9, .99, .999};
  std::vector<int> bases;  // orders
};
Result<Validation> judge_furnaces(const FurnaceChoice& choice);
// A case: every element of the closed `model` against the one radiosity (lm/m²) it should have.
Status judge_furnace(const std::string& name, const GeneratedModel& model, double radiosity,
                     int basis, Validation& v);
// Two: in a closed model of one reflectance the lamps' Φ is absorbed, and Φ/(1-ρ) leaves the
// surfaces in all.
Status judge_lamp_lit(const std::string& name, const GeneratedModel& model, double reflectance,
                      int basis, Validation& v);

// Cases in the manner of CIE 171:2006, compared with closed forms.
Result<Validation> judge_cie171(int basis);
Status judge_diffuse_point_source(int basis, Validation& v);  // 5.2
Status judge_area_source(int basis, Validation& v);           // 5.3
Status judge_flux_conservation(int basis, Validation& v);     // 5.4
Status judge_diffuse_reflection(int basis, Validation& v);    // 5.6, 5.7
Status judge_interreflection(int basis, Validation& v);       // 5.8

// How many gathers it takes where nearly all light is reflected.
Result<Validation> judge_stiffness(int basis);

// Scenes at the edge of what can be computed with, against plain ones with the same light.
Result<Validation> judge_extremes(int basis);

}  // namespace atrium
