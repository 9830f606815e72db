// atrium reference SCENE POINTS.csv: ground truth at points by path tracing, with standard errors.
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <chrono>
#include <ctime>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/points.h"
#include "apps/report_json.h"
#include "apps/solve_options.h"
#include "engine/quantity.h"
#include "solver/reference.h"

namespace atrium {
namespace {

// A point this share of the scene's size off a surface still belongs to it.
constexpr double kOnSurface = 1e-6;

constexpr std::uint64_t kMostPoints = 100'000'000, kMostPaths = std::uint64_t{1} << 32;

struct Reference {
  std::vector<std::string> words;  // SCENE..., and POINTS unless they are drawn
  ImportOptions scene;
  std::string output;
  std::uint64_t paths = 0;  // a point; 0: the default
  double noise = 0;
  std::uint64_t draw = 0;
  std::uint64_t seed = 0;
};

// The run's time, from its making.
class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  double cpu_seconds() const { return double(std::clock() - cpu_start_) / CLOCKS_PER_SEC; }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::clock_t cpu_start_ = std::clock();
};

// As the file has them; "-" is stdin.
Result<std::vector<ProbePoint>> read_points(const std::string& file) {
  const Result<std::string> text = read_input(file);
  if (!text.ok()) return text.status();
  return parse_points(*text, file == "-" ? "stdin" : file);
}

std::vector<SurfacePoint> on_surfaces(const std::vector<ProbePoint>& points,
                                      const PathScene& paths) {
  const Scene& scene = paths.scene();
  const double tolerance = std::max(scene.tolerance, kOnSurface * scene.bounds.diagonal());
  std::vector<SurfacePoint> found;
  for (const ProbePoint& p : points) {
    const Vec3 normal = normalize(p.normal);
    found.push_back({paths.on_surface(scene.frame.to_internal(p.x), normal, tolerance), normal});
  }
  return found;
}

std::vector<ProbePoint> in_file_units(const std::vector<SurfacePoint>& points,
                                      const SceneFrame& frame) {
  std::vector<ProbePoint> out;
  for (const SurfacePoint& p : points) out.push_back({frame.to_file(p.x), p.normal});
  return out;
}

void write_triple(std::ostream& out, const Vec3& v, char end) {
  out << v.x << ',' << v.y << ',' << v.z << end;
}

std::string csv(const std::vector<ProbePoint>& points, const std::vector<ReferencePoint>& found) {
  constexpr int kDigits = 17;
  std::ostringstream rows;
  rows << std::setprecision(kDigits) << "x,y,z,nx,ny,nz,Er,Eg,Eb,seEr,seEg,seEb\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    write_triple(rows, points[i].x, ',');
    write_triple(rows, points[i].normal, ',');
    write_triple(rows, found[i].irradiance, ',');
    write_triple(rows, found[i].standard_error, '\n');
  }
  return rows.str();
}

void say_figures(const ReferenceFigures& f, Console& console) {
  console.say(std::to_string(f.points) + " points, " + std::to_string(f.paths) + " paths, " +
              std::to_string(f.rays) + " rays in " + format_time(f.seconds) + ", " +
              format_time(f.cpu_seconds) + " of CPU; noise " + format_share(f.noise));
}

Status check(const Reference& o, const Global& global) {
  if (o.paths > 0 && o.noise > 0)
    return usage_error("--samples and --noise say both when to stop", "give one of them");
  if (global.json && (o.output.empty() || o.output == "-"))
    return usage_error("--json and the points would both go to stdout", "give -o FILE");
  if (o.draw == 0 && o.words.size() < 2)
    return usage_error("no points given",
                       "name a file of points behind the scene, - for stdin, or use --draw N");
  return {};
}

// What is traced: as the file or the drawing has it, and where that is in the scene.
struct Points {
  std::vector<ProbePoint> given;
  std::vector<SurfacePoint> at;
};

Points drawn_points(const Reference& o, const PathTracer& tracer, Console& console) {
  Points points;
  points.at = draw_lit_points(tracer, o.draw, o.seed);
  points.given = in_file_units(points.at, tracer.scene().scene().frame);
  if (points.at.size() < o.draw)
    console.say("warning: light reaches so little that only " + std::to_string(points.at.size()) +
                " points were drawn");
  return points;
}

// Reads the points before the scene, so that what is wrong with them is told at once.
Result<int> run_reference(const Reference& o, const Global& global, Console& console) {
  ATRIUM_RETURN_IF_ERROR(check(o, global));
  const Clock clock;
  ImportOptions options = o.scene;
  options.files = o.words;
  Points points;
  if (o.draw == 0) {
    options.files.pop_back();
    auto read = read_points(o.words.back());
    if (!read.ok()) return read.status();
    points.given = std::move(*read);
  }
  const Result<Scene> scene = import_scene(options);
  if (!scene.ok()) return scene.status();
  PathTracer tracer(*scene, o.seed);
  if (tracer.scene().lights().empty())
    return Status(Code::kScene, options.files[0], "", "no light: no material emits",
                  "add lamps (Ke in the MTL, emissiveFactor in glTF), a lamps file, or --assign");
  if (o.draw > 0)
    points = drawn_points(o, tracer, console);
  else
    points.at = on_surfaces(points.given, tracer.scene());
  ReferenceOptions how{.noise = o.noise};
  if (o.paths > 0) how.paths = o.paths;
  const auto progress = [&](std::uint64_t done, std::uint64_t wanted) {
    console.progress(clock.seconds(), [&] {
      return format_time(clock.seconds()) + "  " + std::to_string(done) + "/" +
             std::to_string(wanted) + " paths";
    });
  };
  const ReferenceResult found = trace_reference(tracer, points.at, how, progress);
  ATRIUM_RETURN_IF_ERROR(write_output(o.output, {csv(points.given, found.points)}));
  const ReferenceFigures figures{points.at.size(), found.paths,         found.rays,
                                 clock.seconds(),  clock.cpu_seconds(), found.noise};
  say_figures(figures, console);
  if (global.json) std::cout << reference_json(figures);
  return 0;
}

Status set_noise(const std::string& text, double& noise) {
  const Result<double> share = parse_share(text);
  if (!share.ok()) return share.status();
  if (*share <= 0) return usage_error("a noise of nothing is never reached", "write 1% or 0.01");
  noise = *share;
  return {};
}

}  // namespace

Command reference_command() {
  auto reference = std::make_shared<Reference>();
  Reference* r = reference.get();
  Command command{"reference", "irradiance at points by unbiased path tracing", {}, {}};
  OptionSet& o = command.options;
  o.argument("SCENE", "one or more scene files; then a file of points, or - for stdin", 1,
             kMostFiles + 1, r->words);
  o.output("where the points with E and its standard errors go (stdout)", r->output);
  add_scene_options(o, r->scene);
  o.count("samples", "paths a point, in steps of 32 (1024)", 1, kMostPaths,
          [r](std::uint64_t n) { r->paths = n; });
  o.custom("noise",
           "instead: until each point's standard error is below this share of the larger of its E "
           "and the mean",
           "SHARE", [r](const std::string& text) { return set_noise(text, r->noise); });
  o.count("draw",
          "in place of a file: so many points uniform by area on surfaces, each on its front (its "
          "back where only that counts); where a few thousand paths find no light, drawn again",
          1, kMostPoints, [r](std::uint64_t n) { r->draw = n; });
  o.count("seed", "of paths and of what is drawn", 0, UINT64_MAX,
          [r](std::uint64_t seed) { r->seed = seed; });
  command.run = [reference](const Global& global, Console& console) {
    const int threads = global.threads > 0 ? global.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    return run_reference(*reference, global, console);
  };
  return command;
}

}  // namespace atrium
