// validate extremes: scenes at the edge of what can be computed with. A variant holds the same
// light as a plain scene, or light that a closed form tells; its irradiance is compared at the same
// points. Of each, besides: no value is other than finite, none negative, and what is emitted is
// absorbed or escapes.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <optional>

#include "apps/validation/agreement.h"
#include "apps/validation/closed_forms.h"
#include "apps/validation/solved_scene.h"
#include "apps/validation/suites.h"
#include "apps/validation/test_rooms.h"

namespace atrium {
namespace {

using generator::ModelBuilder;

constexpr double kPi = std::numbers::pi;
constexpr double kAsked = 0.01;
constexpr double kTruth = 0.0025;  // asked where a solve stands for the truth
// Twins go to the last level: by its estimate one may end a level before the other.
constexpr double kSettled = 1e-4;
constexpr double kApart = 0.002;  // from the plain scene
constexpr int kPoints = 1000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr Vec3 kRoom{5, 4, 3};
constexpr double kFlux = 5000, kGrey = .6;

// Where a scene was scaled and then moved.
struct Motion {
  double scale = 1;
  Vec3 by{0};
  Vec3 operator()(const Vec3& x) const { return scale * x + by; }
};

GeneratedModel moved(GeneratedModel model, const Motion& motion) {
  for (Vec3& v : model.vertices) v = motion(v);
  return model;
}

// Appends a face as a group of its own.
void add_face(GeneratedModel& model, const std::string& name, PaintId paint,
              std::span<const Vec3> corners) {
  model.groups.push_back({name, static_cast<std::uint32_t>(model.faces.size()), 1});
  model.faces.push_back({paint, static_cast<std::uint32_t>(model.vertices.size()),
                         static_cast<std::uint32_t>(corners.size())});
  model.vertices.insert(model.vertices.end(), corners.begin(), corners.end());
}

// ---- the judge

class Judge {
 public:
  Judge(int basis, Validation& v) : basis_(basis), v_(v) {}

  // E at points; none where no surface stands.
  using Light = std::vector<std::optional<Spectrum>>;

  // Solves the scene, judges what holds for any, and returns the light at the points; nothing where
  // it could not be solved, which is noted.
  Result<std::optional<Light>> light(const std::string& name, const GeneratedModel& model,
                                     std::span<const SurfaceProbe> points,
                                     const Motion& motion = {}, const std::string& assign = "",
                                     double error = kAsked) {
    SolveOptions options = asking(error, basis_);
    options.residual = kSettled;
    const auto scene = SolvedScene::make(model, options, assign);
    if (!scene.ok()) {
      ATRIUM_RETURN_IF_ERROR(note_unsolved(name, scene.status(), v_));
      return std::optional<Light>();
    }
    note_end(name, (*scene)->summary(), v_);
    judge_energy(name, (*scene)->summary());
    ATRIUM_RETURN_IF_ERROR(judge_elements(name, **scene));
    Light light;
    for (const SurfaceProbe& p : points) {
      const auto sample = (*scene)->at({motion(p.x), p.normal});
      if (!sample.ok()) return sample.status();
      light.push_back(*sample ? std::optional((*sample)->irradiance) : std::nullopt);
    }
    return std::optional(std::move(light));
  }

  // How far the variant is from the plain one where that has light. `lamps` is what each channel of
  // its lamps is of the plain ones'.
  double apart(const Light& variant, const Light& plain,
               const Spectrum& lamps = Spectrum{1}) const {
    std::vector<double> found, expected;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      if (!plain[i]) continue;
      expected.push_back(luminance(*plain[i]));
      found.push_back(variant[i] ? luminance(*variant[i] / lamps) : kNaN);
    }
    return nrmse(found, expected);
  }
  double apart(const Light& found, std::span<const double> expected) const {
    std::vector<double> values;
    for (const std::optional<Spectrum>& e : found) values.push_back(e ? luminance(*e) : kNaN);
    return nrmse(values, expected);
  }
  void note(ValidationCase c) { v_.cases.push_back(std::move(c)); }

 private:
  void judge_energy(const std::string& name, const SolveSummary& s) {
    const double lost = s.flux_emitted - s.flux_absorbed - s.flux_escaped;
    note(within(name + ": share of flux lost", 0, lost / s.flux_emitted, kAsked));
  }

  // Every coefficient is a number, and no element is darker than black in the mean.
  Status judge_elements(const std::string& name, SolvedScene& scene) {
    std::size_t broken = 0;
    ATRIUM_RETURN_IF_ERROR(
        scene.solution().for_each_cluster([&](ClusterId, const ClusterView& cluster) {
          for (std::size_t p = 0; p < cluster.size(); ++p) {
            const PatchView tree = cluster.patch(p);
            for (std::size_t i = 0; i < tree.elements.size(); ++i)
              broken += is_broken(tree.e_of(i));
          }
        }));
    note(within(name + ": broken elements", 0, double(broken), 0));
    return {};
  }
  static bool is_broken(std::span<const double> e) {
    return !std::all_of(e.begin(), e.end(), [](double x) { return std::isfinite(x); }) ||
           *std::min_element(e.begin(), e.begin() + kChannels) < 0;
  }

  int basis_;
  Validation& v_;
};

// ---- one plain room, moved about and littered

struct Variant {
  std::string name;
  GeneratedModel model;
  Motion motion = {};
  Spectrum lamps{1};  // of the plain ones, channel by channel
  std::string assign = "";
};

// A plain scene and what should be no different.
Status judge_family(Judge& judge, const std::string& plain_name, const GeneratedModel& plain,
                    std::span<const Variant> variants) {
  const std::vector<SurfaceProbe> points = points_by_area(plain, kPoints);
  const auto expected = judge.light(plain_name, plain, points);
  if (!expected.ok()) return expected.status();
  if (!*expected) return {};
  for (const Variant& x : variants) {
    const auto found = judge.light(x.name, x.model, points, x.motion, x.assign);
    if (!found.ok()) return found.status();
    if (*found)
      judge.note(within(x.name + ": off the plain one", 0,
                        judge.apart(**found, **expected, x.lamps), kApart));
  }
  return {};
}

// A twin whose surfaces are cut otherwise is refined otherwise, and as far from the plain one as
// either is from the truth: it may be no farther from that than the plain one is. The plain scene,
// solved more finely, stands for it.
Status judge_twin(Judge& judge, const std::string& plain_name, const GeneratedModel& plain,
                  const Variant& twin) {
  const std::vector<SurfaceProbe> points = points_by_area(plain, kPoints);
  const auto truth = judge.light(plain_name + ", finely", plain, points, {}, "", kTruth);
  if (!truth.ok()) return truth.status();
  const auto usual = judge.light(plain_name, plain, points);
  if (!usual.ok()) return usual.status();
  const auto found = judge.light(twin.name, twin.model, points);
  if (!found.ok()) return found.status();
  if (!*truth || !*usual || !*found) return {};
  judge.note(at_most(twin.name + ": error beyond the plain one's", kApart,
                     judge.apart(**found, **truth) - judge.apart(**usual, **truth)));
  return {};
}

constexpr double kFar = 1e6, kSmall = 1e-6, kLarge = 1e6, kChannelRatio = 1e-6;

// Long, narrow faces in the air: they hide a millionth of the room.
GeneratedModel with_slivers(GeneratedModel model) {
  constexpr double kLong = 2, kAspect = 1e6;
  constexpr int kSlivers = 5;
  for (int i = 0; i < kSlivers; ++i) {
    const Vec3 at{1. + .5 * i, 1., .5 + .4 * i};
    const Vec3 along = kLong * normalize(Vec3{.2 * i, 1, .1 * i});
    const Vec3 across = kLong / kAspect * normalize(cross(along, Vec3{1, .3, .2 * i}));
    const std::array face{at, at + along, at + along + across, at + across};
    add_face(model, "sliver" + std::to_string(i), 0, face);
  }
  return model;
}

// Faces without area: a corner said twice or thrice, and corners in a row.
GeneratedModel with_empty_faces(GeneratedModel model) {
  const Vec3 a{1, 1, 1}, b{2, 1, 1.5};
  add_face(model, "empty/point", 0, std::array{a, a, a});
  add_face(model, "empty/edge", 0, std::array{a, b, a});
  add_face(model, "empty/row", 0, std::array{a, 0.25 * (3. * a + b), 0.5 * (a + b), b});
  return model;
}

// Every face once more, in an object of its own.
GeneratedModel with_duplicates(GeneratedModel model) {
  const std::size_t faces = model.faces.size();
  for (std::size_t f = 0; f < faces; ++f) {
    const PolygonView corners = model.polygon(model.faces[f]);
    add_face(model, "again" + std::to_string(f), model.faces[f].paint,
             Polygon(corners.begin(), corners.end()));
  }
  return model;
}

GeneratedModel with_lamps(GeneratedModel model, const Spectrum& scale) {
  for (Paint& p : model.paints) p.luminance *= scale;
  return model;
}

Status judge_litter(Judge& judge) {
  Result<GeneratedModel> made = generate({.kind = "cornell"});
  if (!made.ok()) return made.status();
  const GeneratedModel& plain = *made;
  const auto move = [&](const char* name, const Motion& motion) {
    return Variant{name, moved(plain, motion), motion};
  };
  ATRIUM_RETURN_IF_ERROR(judge_family(
      judge, "cornell", plain,
      std::array{move("1e6 m away", {1, {kFar, -kFar, kFar}}), move("scale 1e-6", {kSmall}),
                 move("scale 1e6", {kLarge}), Variant{"slivers 1:1e6", with_slivers(plain)},
                 Variant{"zero-area faces", with_empty_faces(plain)},
                 Variant{"duplicate faces", with_duplicates(plain)}}));
  // Grey: each channel is the same light, times its lamps'.
  const Result<GeneratedModel> grey = furnished_room("cornell", kGrey);
  if (!grey.ok()) return grey.status();
  const Spectrum channels{1, std::sqrt(kChannelRatio), kChannelRatio};
  return judge_family(
      judge, "grey cornell", *grey,
      std::array{Variant{"channels 1 to 1e-6", with_lamps(*grey, channels), {}, channels}});
}

// ---- plain twins

GeneratedModel room_with(const std::function<void(ModelBuilder&, PaintId)>& furnish) {
  ModelBuilder out;
  const PaintId grey = out.paint("grey", Spectrum{kGrey});
  add_room(out, grey, kRoom);
  const LampPlace lamp = middle_of(kRoom, 1);
  add_lamp(out, out.paint("lamp", Spectrum{kGrey}, Spectrum{lamp_luminance(kFlux, lamp.area())}),
           lamp, kRoom.z);
  furnish(out, grey);
  return out.take("room");
}

// A screen of two faces back to back in one plane, each its own side; its twin is one face that
// both sides of which count.
Status judge_back_to_back(Judge& judge) {
  const auto screen = [](bool both) {
    return room_with([both](ModelBuilder& out, PaintId) {
      const PaintId paint = out.paint("screen", Spectrum{kGrey});
      const Vec3 lo{2, 1, 0}, hi{2, 3, 1.5};
      out.begin("screen");
      out.rectangle(paint, 0, 1, lo, hi);
      if (!both) return;
      out.begin("screen_behind");
      out.rectangle(paint, 0, -1, lo, hi);
    });
  };
  const std::string two_sided = "[[material]]\nmatch = \"screen\"\nsides = 2\n";
  // The faces' points: those of the plain twin's front would leave out half.
  const std::vector<SurfaceProbe> points = points_by_area(screen(true), kPoints);
  const auto plain = judge.light("two-sided screen", screen(false), points, {}, two_sided);
  if (!plain.ok()) return plain.status();
  const auto found = judge.light("screen back to back", screen(true), points);
  if (!found.ok()) return found.status();
  if (*plain && *found)
    judge.note(
        within("screen back to back: off the plain one", 0, judge.apart(**found, **plain), kApart));
  return {};
}

// A post through a bench; its twin has what shows of both and no more.
Status judge_intersecting(Judge& judge) {
  constexpr Range kBenchX{1, 3.5}, kBenchY{1, 2.5}, kPostX{1.5, 2}, kPostY{1.5, 2};
  constexpr double kBench = .5, kPost = 1.5;
  const GeneratedModel crossing = room_with([&](ModelBuilder& out, PaintId paint) {
    out.begin("bench");
    out.box(paint, {kBenchX.lo, kBenchY.lo, 0}, {kBenchX.hi, kBenchY.hi, kBench},
            generator::kBottomFace);
    out.begin("post");
    out.box(paint, {kPostX.lo, kPostY.lo, 0}, {kPostX.hi, kPostY.hi, kPost},
            generator::kBottomFace);
  });
  const GeneratedModel apart = room_with([&](ModelBuilder& out, PaintId paint) {
    out.begin("bench");
    out.box(paint, {kBenchX.lo, kBenchY.lo, 0}, {kBenchX.hi, kBenchY.hi, kBench},
            generator::kBottomFace | generator::kTopFace);
    const auto top = [&](Range x, Range y) {
      out.rectangle(paint, 2, 1, {x.lo, y.lo, kBench}, {x.hi, y.hi, kBench});
    };
    top(kBenchX, {kBenchY.lo, kPostY.lo});
    top(kBenchX, {kPostY.hi, kBenchY.hi});
    top({kBenchX.lo, kPostX.lo}, kPostY);
    top({kPostX.hi, kBenchX.hi}, kPostY);
    out.begin("post");
    out.box(paint, {kPostX.lo, kPostY.lo, kBench}, {kPostX.hi, kPostY.hi, kPost},
            generator::kBottomFace);
  });
  return judge_twin(judge, "post on a bench", apart, {"post through a bench", crossing});
}

// Of 1e-8 of the room's area. From a meter off, a lamp of 2 cm is as much a point, to 1e-4.
Status judge_tiny_emitter(Judge& judge) {
  const double area = 2 * (kRoom.x * kRoom.y + kRoom.y * kRoom.z + kRoom.z * kRoom.x);
  constexpr double kShare = 1e-8, kPlainSide = .02;
  const auto lit = [](double side) {
    return lamp_lit_room(kGrey, kRoom, middle_of(kRoom, side), kFlux);
  };
  return judge_twin(judge, "lamp of 2 cm", lit(kPlainSide),
                    {"emitter of 1e-8", lit(std::sqrt(kShare * area))});
}

// White of exactly 1 is taken as .9, as import says it.
Status judge_all_white(Judge& judge) {
  const auto painted = [](double reflectance) {
    return lamp_lit_room(reflectance, kRoom, middle_of(kRoom, 1), kFlux);
  };
  constexpr double kWhite = .9;
  return judge_family(judge, "all of .9", painted(kWhite),
                      std::array{Variant{"all white", painted(1)}});
}

// ---- closed forms

// A lamp in a black room's ceiling, against the point's configuration factors on floor and wall.
Status judge_black_room(Judge& judge, const std::string& name, const LampPlace& lamp) {
  const double exitance = kFlux / lamp.area();
  std::vector<SurfaceProbe> points;
  std::vector<double> expected;
  constexpr int kGrid = 20;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const double s = (i + .5) / kGrid, t = (j + .5) / kGrid;
      const double x = s * kRoom.x, y = t * kRoom.y, z = s * kRoom.z;
      points.push_back({{x, y, 0}, {0, 0, 1}});
      expected.push_back(exitance * element_to_parallel({lamp.x0 - x, lamp.x1 - x},
                                                        {lamp.y0 - y, lamp.y1 - y}, kRoom.z));
      points.push_back({{0, y, z}, {1, 0, 0}});
      expected.push_back(exitance * element_to_perpendicular({lamp.x0, lamp.x1},
                                                             {lamp.y0 - y, lamp.y1 - y},
                                                             kRoom.z - z));
    }
  const auto found = judge.light(name, lamp_lit_room(0, kRoom, lamp, kFlux), points);
  if (!found.ok()) return found.status();
  if (*found)
    judge.note(within(name + ": off closed forms", 0, judge.apart(**found, expected), kAsked));
  return {};
}

// Each surface its own reflectance, from none to nearly all.
Status judge_mixed(Judge& judge) {
  Result<GeneratedModel> made = generate({.kind = "cornell"});
  if (!made.ok()) return made.status();
  const std::array reflectances{.99999, 0., .999, .5, .99, .9};
  std::vector<Paint>& paints = made->paints;
  for (std::size_t i = 0; i < paints.size(); ++i)
    paints[i].reflectance = Spectrum{reflectances[i % reflectances.size()]};
  const auto light = judge.light("rho 0 to .99999", *made, points_by_area(*made, kPoints));
  return light.ok() ? Status() : light.status();
}

// A lamp that shines up over a plate that looks down, in the open.
Status judge_apart(Judge& judge) {
  ModelBuilder out;
  out.begin("lamp");
  out.rectangle(out.paint("lamp", Spectrum{kGrey}, Spectrum{kFlux / kPi}), 2, 1, {0, 0, 1},
                {1, 1, 1});
  out.begin("plate");
  out.rectangle(out.paint("grey", Spectrum{kGrey}), 2, -1, {0, 0, 0}, {1, 1, 0});
  const GeneratedModel model = out.take("apart");
  const auto light = judge.light("nothing sees anything", model, points_by_area(model, kPoints));
  return light.ok() ? Status() : light.status();
}

}  // namespace

Result<Validation> judge_extremes(int basis) {
  Validation v;
  Judge judge(basis, v);
  for (const auto part : {judge_litter, judge_back_to_back, judge_intersecting, judge_tiny_emitter,
                          judge_all_white, judge_mixed, judge_apart})
    ATRIUM_RETURN_IF_ERROR(part(judge));
  ATRIUM_RETURN_IF_ERROR(judge_black_room(judge, "all black", middle_of(kRoom, 1)));
  ATRIUM_RETURN_IF_ERROR(judge_black_room(judge, "lamp touching a wall", {0, 1.5, 1, 2.5}));
  return v;
}

}  // namespace atrium
