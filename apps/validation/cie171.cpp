// validate cie171: cases in the manner of CIE 171:2006, compared with closed forms computed here.
// The numbers are the report's; where its printed tables are rounded or wrong (5.3, 5.7) the closed
// form stands.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "apps/validation/closed_forms.h"
#include "apps/validation/solved_scene.h"
#include "apps/validation/suites.h"
#include "apps/validation/test_rooms.h"

namespace atrium {
namespace {

using generator::ModelBuilder;

constexpr double kPi = std::numbers::pi;
// The worst of some forty points is off by three times the root mean square that is asked for.
constexpr double kAsked = 0.003, kAllowed = 0.01;

constexpr double kFlux = 10000;      // lm
constexpr double kLuminance = 1000;  // cd/m²
constexpr Vec3 kUp{0, 0, 1}, kDown{0, 0, -1}, kEast{1, 0, 0};

// Where points stand along the half of a plane: from its edge to its middle, or as far again.
constexpr std::array kHalfPlane{.25, .75, 1.25, 1.75};

std::string at_place(const char* name, double x, double y, double z) {
  char text[96];
  std::snprintf(text, sizeof text, "%s at %.4g %.4g %.4g", name, x, y, z);
  return text;
}

Status judge_point(const char* name, SolvedScene& scene, const SurfaceProbe& probe, double expected,
                   Validation& v) {
  return judge_illuminance(at_place(name, probe.x.x, probe.x.y, probe.x.z), scene, probe, expected,
                           kAllowed * expected, v);
}

// ---- 5.6, 5.7: a horizontal reflector 4 x 4 about the origin, a wall that begins over its edge
// and a ceiling over it.

constexpr double kHalf = 2, kCeiling = 3, kSill = .5;
// The black box between them, as long as the reflector is wide.
constexpr Range kBoxDepth{-.5, .5}, kBoxHeight{1.4, 1.6};

GeneratedModel reflector_scene(bool obstructed) {
  ModelBuilder out;
  const PaintId black = out.paint("black", Spectrum{0});
  out.begin("reflector");
  out.rectangle(out.paint("reflector", Spectrum{0}, Spectrum{kLuminance}), 2, 1,
                {-kHalf, -kHalf, 0}, {kHalf, kHalf, 0});
  out.begin("wall");
  out.rectangle(black, 0, 1, {-kHalf, -kHalf, kSill}, {-kHalf, kHalf, kCeiling});
  out.begin("ceiling");
  out.rectangle(black, 2, -1, {-kHalf, -kHalf, kCeiling}, {kHalf, kHalf, kCeiling});
  if (obstructed) {
    out.begin("obstruction");
    out.box(black, {kBoxDepth.lo, -kHalf, kBoxHeight.lo}, {kBoxDepth.hi, kHalf, kBoxHeight.hi});
  }
  return out.take("reflector");
}

// The x of the reflector that the box hides from a point at (x, z) of the plane y = 0. The box is
// as long as the reflector and nearer: what it hides is a strip from side to side.
Range hidden_strip(double x, double z) {
  constexpr double kEverything = std::numeric_limits<double>::infinity();
  Range strip{kEverything, -kEverything};
  for (const double bx : {kBoxDepth.lo, kBoxDepth.hi})
    for (const double bz : {kBoxHeight.lo, kBoxHeight.hi}) {
      // A corner that is not below the point hides all beyond it.
      const double on_floor =
          bz < z ? x + (bx - x) * z / (z - bz) : std::copysign(kEverything, bx - x);
      strip.lo = std::min(strip.lo, on_floor);
      strip.hi = std::max(strip.hi, on_floor);
    }
  return {std::clamp(strip.lo, -kHalf, kHalf), std::clamp(strip.hi, -kHalf, kHalf)};
}

// The configuration factor of the reflector's part x from a point over it.
double from_ceiling(double at_x, Range x) {
  return element_to_parallel({x.lo - at_x, x.hi - at_x}, {-kHalf, kHalf}, kCeiling);
}
double from_wall(double at_z, Range x) {
  return element_to_perpendicular({x.lo + kHalf, x.hi + kHalf}, {-kHalf, kHalf}, at_z);
}

Status judge_reflector(const char* name, bool obstructed, int basis, Validation& v) {
  const auto scene = SolvedScene::make(reflector_scene(obstructed), asking(kAsked, basis));
  if (!scene.ok()) return note_unsolved(name, scene.status(), v);
  constexpr Range kAll{-kHalf, kHalf};
  const double exitance = kPi * kLuminance;
  for (const double along : kHalfPlane) {
    const double x = along - kHalf;
    const double hidden = obstructed ? from_ceiling(x, hidden_strip(x, kCeiling)) : 0;
    ATRIUM_RETURN_IF_ERROR(judge_point(name, **scene, {{x, 0, kCeiling}, kDown},
                                       exitance * (from_ceiling(x, kAll) - hidden), v));
  }
  for (const double up : {.25, .75, 1.25, 1.75, 2.25}) {
    const double z = kSill + up;
    const double hidden = obstructed ? from_wall(z, hidden_strip(-kHalf, z)) : 0;
    ATRIUM_RETURN_IF_ERROR(judge_point(name, **scene, {{-kHalf, 0, z}, kEast},
                                       exitance * (from_wall(z, kAll) - hidden), v));
  }
  return {};
}

}  // namespace

// E = I₀h²/d⁴ under a lamp so small that nothing of its size is left.
Status judge_diffuse_point_source(int basis, Validation& v) {
  constexpr const char* kName = "5.2 diffuse point";
  constexpr double kHeight = 3, kIntensity = 1000, kSide = .01, kPlane = 2;
  ModelBuilder out;
  out.begin("plane");
  out.rectangle(out.paint("black", Spectrum{0}), 2, 1, {-kPlane, -kPlane, 0}, {kPlane, kPlane, 0});
  add_lamp(out, out.paint("lamp", Spectrum{0}, Spectrum{kIntensity / (kSide * kSide)}),
           {-kSide / 2, -kSide / 2, kSide / 2, kSide / 2}, kHeight);
  const auto scene = SolvedScene::make(out.take("point source"), asking(kAsked, basis));
  if (!scene.ok()) return note_unsolved(kName, scene.status(), v);
  for (const Vec2& p : {Vec2{0, 0}, Vec2{.5, 0}, Vec2{1, 0}, Vec2{1.5, 0}, Vec2{.5, .5},
                        Vec2{1, .5}, Vec2{1.5, .5}, Vec2{1, 1}, Vec2{1.5, 1}, Vec2{1.5, 1.5}}) {
    const double d2 = dot(p, p) + kHeight * kHeight;
    ATRIUM_RETURN_IF_ERROR(judge_point(kName, **scene, {{p.x, p.y, 0}, kUp},
                                       kIntensity * kHeight * kHeight / (d2 * d2), v));
  }
  return {};
}

// E = πL·C along the floor's middle line.
Status judge_area_source(int basis, Validation& v) {
  constexpr const char* kName = "5.3 area source";
  constexpr double kSide = 1;
  const Vec3 size{4, 4, 3};
  const LampPlace lamp = middle_of(size, kSide);
  const auto scene = SolvedScene::make(lamp_lit_room(0, size, lamp, kPi * kLuminance * lamp.area()),
                                       asking(kAsked, basis));
  if (!scene.ok()) return note_unsolved(kName, scene.status(), v);
  for (const double x : kHalfPlane) {
    const double c =
        element_to_parallel({lamp.x0 - x, lamp.x1 - x}, {-kSide / 2, kSide / 2}, size.z);
    ATRIUM_RETURN_IF_ERROR(
        judge_point(kName, **scene, {{x, size.y / 2, 0}, kUp}, kPi * kLuminance * c, v));
  }
  return {};
}

// Σ E·A = Φ in a closed black room.
Status judge_flux_conservation(int basis, Validation& v) {
  constexpr const char* kName = "5.4 flux that arrives";
  const Vec3 size{4, 4, 3};
  const auto scene =
      SolvedScene::make(lamp_lit_room(0, size, middle_of(size, 1), kFlux), asking(kAsked, basis));
  if (!scene.ok()) return note_unsolved(kName, scene.status(), v);
  const Result<Totals> sum = (*scene)->totals();
  if (!sum.ok()) return sum.status();
  v.cases.push_back(within(kName, kFlux, sum->arrived, kAsked * kFlux));
  return {};
}

// E/M is the configuration factor of what is seen of the reflector.
Status judge_diffuse_reflection(int basis, Validation& v) {
  ATRIUM_RETURN_IF_ERROR(judge_reflector("5.6 reflector", false, basis, v));
  return judge_reflector("5.7 obstructed", true, basis, v);
}

// The indirect part of E, in the mean over a closed cube: Φρ/(A(1-ρ)), wherever the lamp is.
Status judge_interreflection(int basis, Validation& v) {
  // Sweeps without any acceleration come to an end at ρ = .999 in fewer.
  constexpr std::uint64_t kMostGathers = 8000;
  const Vec3 size{4, 4, 4};
  for (const double rho : {.1, .5, .9, .95, .99, .999}) {
    char name[64];
    std::snprintf(name, sizeof name, "5.8 indirect, rho %.4g", rho);
    SolveOptions asked = asking(kAllowed, basis);
    asked.iterations = kMostGathers;
    const auto scene =
        SolvedScene::make(lamp_lit_room(rho, size, middle_of(size, 1), kFlux), asked);
    if (!scene.ok()) {
      ATRIUM_RETURN_IF_ERROR(note_unsolved(name, scene.status(), v));
      continue;
    }
    note_end(name, (*scene)->summary(), v);
    const Result<Totals> sum = (*scene)->totals();
    if (!sum.ok()) return sum.status();
    const double area = 6 * size.x * size.y, expected = kFlux * rho / (area * (1 - rho));
    const double found = (sum->arrived - kFlux) / area;
    // What is asked for is a share of all of E.
    v.cases.push_back(within(name, expected, found, kAllowed * (expected + kFlux / area)));
  }
  return {};
}

Result<Validation> judge_cie171(int basis) {
  Validation v;
  for (const auto judge : {judge_diffuse_point_source, judge_area_source, judge_flux_conservation,
                           judge_diffuse_reflection, judge_interreflection})
    ATRIUM_RETURN_IF_ERROR(judge(basis, v));
  return v;
}

}  // namespace atrium
