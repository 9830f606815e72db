// atrium render RUN -o view.png|.exr: a picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/picture/encode.h"
#include "apps/picture/render.h"
#include "apps/picture/tone.h"
#include "apps/picture/viewpoint.h"
#include "apps/report_json.h"

namespace atrium {
namespace {

constexpr int kWidth = 1280, kHeight = 800, kOverheadWidth = 1600;
constexpr std::uint64_t kMostPixels = 16384;    // a side
constexpr std::uint64_t kMostSamples = 8;       // a pixel's side
constexpr double kFov = 60, kOverheadFov = 20;  // degrees, of the picture's height
constexpr double kNarrowest = 0.01, kWidest = 170;
constexpr Pixel kBackground{0.012f, 0.014f, 0.018f};  // of a PNG, where nothing is
constexpr float kLine = 0.3f;                         // of the colour under an element's edge

struct Render {
  std::vector<std::string> run;
  std::string output;
  std::optional<Vec3> eye, target, up;
  std::optional<double> fov, cut_height, exposure;
  int width = 0, height = 0, samples = 3;
  bool overhead = false, mesh = false;
};

OptionSet render_options(Render& r) {
  OptionSet o;
  const auto number = [&](const char* name, const char* help, double least, double most,
                          std::optional<double>& target) {
    o.custom(name, help, "NUMBER", [=, &target](const std::string& text) -> Status {
      const Result<double> value = parse_number(text);
      if (!value.ok()) return value.status();
      if (*value < least || *value > most)
        return usage_error("'" + text + "' is out of range", "take a smaller or larger one");
      target = *value;
      return {};
    });
  };
  const auto count = [&](const char* name, const char* help, std::uint64_t most, int& target) {
    o.count(name, help, 1, most, [&target](std::uint64_t n) { target = static_cast<int>(n); });
  };
  constexpr double kAny = std::numeric_limits<double>::max();
  o.argument("RUN", "a run directory", 1, 1, r.run);
  o.output("the picture: .png (8 bits, exposed) or .exr (floats, cd/m2)", r.output);
  o.point("eye", "where the eye is, in the scene's units (a good place)", r.eye);
  o.point("look-at", "what it looks at", r.target);
  o.point("up", "which way is up (against the lamps' light)", r.up);
  number("fov", "angle of view over the picture's height, degrees", kNarrowest, kWidest, r.fov);
  count("width", "of the picture, pixels", kMostPixels, r.width);
  count("height", "of the picture, pixels", kMostPixels, r.height);
  count("samples", "N x N a pixel", kMostSamples, r.samples);
  number("exposure", "EV: cd/m2 times 2^EV, 1 is white (automatic)", -100, 100, r.exposure);
  o.flag("overhead", "from above, without the ceiling", r.overhead);
  number("cut-height", "with --overhead: leave out what is higher, in the scene's units", -kAny,
         kAny, r.cut_height);
  o.flag("mesh", "the elements' edges on top", r.mesh);
  return o;
}

Status check(const Render& r, const std::string& kind) {
  if (r.output.empty()) return usage_error("render needs -o FILE", "name a .png or .exr file");
  if (kind != ".png" && kind != ".exr")
    return usage_error("no pictures of kind '" + kind + "'", "name a .png or .exr file");
  if (r.eye.has_value() != r.target.has_value())
    return usage_error("--eye and --look-at go together", "give both or neither");
  if (r.eye && *r.eye == *r.target)
    return usage_error("--eye and --look-at are one point", "move one of them");
  if (r.overhead && r.eye)
    return usage_error("--overhead finds its own place", "leave out --eye and --look-at");
  if (r.cut_height && !r.overhead)
    return usage_error("--cut-height belongs to --overhead", "add --overhead");
  if (r.up && *r.up == Vec3(0)) return usage_error("--up points nowhere", "write it as 0,0,1");
  return {};
}

// Where the eye is and what is left out; sizes that are not given are filled in.
Result<RenderOptions> set_up(Render& r, Solution& solution, LitScene& scene) {
  const RunModel& run = solution.run();
  RenderOptions options;
  Result<Vec3> up = r.up ? Result<Vec3>(normalize(*r.up)) : up_direction(solution);
  if (!up.ok()) return up.status();
  if (r.overhead) {
    std::optional<double> cut, aspect;
    if (r.cut_height) cut = *r.cut_height * run.frame.unit - dot(run.frame.origin, *up);
    if (r.width > 0 && r.height > 0) aspect = static_cast<double>(r.width) / r.height;
    const Overhead view = overhead_view(run, *up, r.fov.value_or(kOverheadFov), cut, aspect);
    if (r.width == 0 && r.height == 0) r.width = kOverheadWidth;
    const auto scaled = [](double n) {
      return std::clamp(static_cast<int>(std::lround(n)), 1, int(kMostPixels));
    };
    if (r.width == 0) r.width = scaled(r.height * view.aspect);
    if (r.height == 0) r.height = scaled(r.width / view.aspect);
    options.camera = view.camera;
    options.cut = view.cut;
  } else {
    if (r.width == 0) r.width = r.height > 0 ? r.height * kWidth / kHeight : kWidth;
    if (r.height == 0) r.height = std::max(1, r.width * kHeight / kWidth);
    const double fov = r.fov.value_or(kFov);
    if (r.eye) {
      options.camera =
          look_at(run.frame.to_internal(*r.eye), run.frame.to_internal(*r.target), *up, fov);
    } else {
      const auto view = interior_view(scene, *up, fov, static_cast<double>(r.width) / r.height);
      if (!view.ok()) return view.status();
      options.camera = *view;
    }
  }
  options.camera.width = r.width;
  options.camera.height = r.height;
  options.side = r.samples;
  options.mesh = r.mesh;
  return options;
}

double exposure_of(const Rendering& rendering) {
  std::vector<Weighted> values;
  for (std::size_t i = 0; i < rendering.what.size(); ++i) {
    const Pixel& p = rendering.luminance.pixels[i];
    if (rendering.what[i] == kSurface) values.push_back({luminance(Spectrum(p[0], p[1], p[2])), 1});
  }
  return automatic_exposure(std::move(values));
}

// Samples are exposed before they are averaged, so that the rims of lamps stay smooth.
Image exposed(const Rendering& rendering, double ev) {
  Image image = rendering.luminance;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    Pixel& p = image.pixels[i];
    if (rendering.what[i] == kNothing) {
      p = kBackground;
      continue;
    }
    p = tone_mapped(p, ev);
    if (rendering.what[i] == kEdge)
      for (float& c : p) c *= kLine;
  }
  return image;
}

std::string shown(const Vec3& v) {
  char text[96];
  std::snprintf(text, sizeof text, "%.6g,%.6g,%.6g", v.x, v.y, v.z);
  return text;
}

void say_view(const Render& r, const Camera& camera, const SceneFrame& frame, Console& console) {
  const Vec3 target = camera.eye + camera.forward;
  std::string line = r.output + ": --eye " + shown(frame.to_file(camera.eye)) + " --look-at " +
                     shown(frame.to_file(target)) + " --up " + shown(camera.up);
  if (r.exposure) line += " --exposure " + std::to_string(*r.exposure);
  console.say(line);
}

Result<int> run_render(Render& r, const Global& global, Console& console) {
  const std::string kind = std::filesystem::path(r.output).extension().string();
  ATRIUM_RETURN_IF_ERROR(check(r, kind));
  const auto solution = Solution::open(r.run.front(), kReadingArena);
  if (!solution.ok()) return solution.status();
  LitScene scene(**solution);
  Result<RenderOptions> options = set_up(r, **solution, scene);
  if (!options.ok()) return options.status();
  options->threads = global.threads;
  const Result<Rendering> rendering = render(scene, *options);
  if (!rendering.ok()) return rendering.status();
  if (kind == ".png" && !r.exposure) r.exposure = exposure_of(*rendering);
  const Image full = kind == ".png" ? exposed(*rendering, *r.exposure) : rendering->luminance;
  const Image image = shrink(full, r.samples);
  const Result<std::string> bytes = kind == ".png" ? encode_png(image) : encode_exr(image);
  if (!bytes.ok()) return bytes.status();
  ATRIUM_RETURN_IF_ERROR(write_output(r.output, {*bytes}));
  say_view(r, options->camera, (*solution)->run().frame, console);
  if (global.json) std::cout << picture_json(r.output, image.width, image.height, r.exposure);
  return 0;
}

}  // namespace

Command render_command() {
  auto render = std::make_shared<Render>();
  return {"render", "a picture of a solution", render_options(*render),
          [render](const Global& global, Console& console) {
            return run_render(*render, global, console);
          }};
}

}  // namespace atrium
