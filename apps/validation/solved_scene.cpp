#include "apps/validation/solved_scene.h"

#include <stdlib.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <random>

#include "apps/output.h"

namespace atrium {
namespace {

// A point so many tolerances of the scene off a surface still belongs to it.
constexpr double kOnSurface = 10;
constexpr std::size_t kArena = std::size_t{64} << 20;  // bytes, for records while reading

// A directory of this process's own, gone with the object.
class TemporaryDirectory {
 public:
  static Result<std::unique_ptr<TemporaryDirectory>> make() {
    std::error_code why;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(why);
    std::string name = (parent / "atrium-validate-XXXXXX").string();
    if (!why && mkdtemp(name.data()) == nullptr) why.assign(errno, std::generic_category());
    if (why)
      return Status(Code::kStore, name, "", "no temporary directory: " + why.message(),
                    "set TMPDIR to a directory that can be written to");
    return std::unique_ptr<TemporaryDirectory>(new TemporaryDirectory(name));
  }
  // What cannot be removed stays: no verdict depends on it.
  ~TemporaryDirectory() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  explicit TemporaryDirectory(std::string path) : path_(std::move(path)) {}
  std::filesystem::path path_;
};

// A point of a convex polygon, uniform by area: of the fan's triangles one by area, then within it.
Vec3 point_in(PolygonView polygon, double pick, double s, double t) {
  double left = pick * area(polygon);
  std::size_t i = 1;
  for (; i + 2 < polygon.size(); ++i) {
    const double a = 0.5 * length(cross(polygon[i] - polygon[0], polygon[i + 1] - polygon[0]));
    if (left <= a) break;
    left -= a;
  }
  if (s + t > 1) {
    s = 1 - s;
    t = 1 - t;
  }
  return polygon[0] + s * (polygon[i] - polygon[0]) + t * (polygon[i + 1] - polygon[0]);
}

}  // namespace

struct SolvedScene::Parts {
  std::unique_ptr<TemporaryDirectory> directory;  // removed last: the solution reads there
  SolveSummary summary;
  std::unique_ptr<Solution> solution;
};

SolvedScene::SolvedScene(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
SolvedScene::~SolvedScene() = default;
const SolveSummary& SolvedScene::summary() const { return parts_->summary; }
Solution& SolvedScene::solution() { return *parts_->solution; }

Result<std::unique_ptr<SolvedScene>> SolvedScene::make(const GeneratedModel& model,
                                                       SolveOptions asked,
                                                       const std::string& assign) {
  auto parts = std::make_unique<Parts>();
  auto directory = TemporaryDirectory::make();
  if (!directory.ok()) return directory.status();
  parts->directory = std::move(directory).value();
  const std::string scene = *parts->directory / "scene.obj";
  ATRIUM_RETURN_IF_ERROR(write_obj(model, scene));
  if (!assign.empty()) {
    asked.scene.assign_file = *parts->directory / "assign.toml";
    ATRIUM_RETURN_IF_ERROR(write_output(asked.scene.assign_file, {assign}));
  }
  asked.scene.files = {scene};
  asked.scene.sides = SidesChoice::kOne;
  asked.run_directory = *parts->directory / "run";
  Result<SolveSummary> summary = solve(asked, {}, {});
  if (!summary.ok()) return summary.status();
  parts->summary = std::move(summary).value();
  auto solution = Solution::open(asked.run_directory, kArena);
  if (!solution.ok()) return solution.status();
  parts->solution = std::move(solution).value();
  return std::unique_ptr<SolvedScene>(new SolvedScene(std::move(parts)));
}

Result<std::optional<SurfaceSample>> SolvedScene::at(const SurfaceProbe& probe) {
  const RunModel& run = solution().run();
  const Vec3 x = run.frame.to_internal(probe.x);
  const std::optional<PatchId> patch =
      solution().patch_at(x, probe.normal, kOnSurface * run.tolerance);
  if (!patch) return std::optional<SurfaceSample>();
  const Result<SurfaceSample> sample = solution().sample(*patch, x);
  if (!sample.ok()) return sample.status();
  return std::optional<SurfaceSample>(*sample);
}

Result<Totals> SolvedScene::totals() {
  Totals sum;
  ATRIUM_RETURN_IF_ERROR(solution().for_each_cluster([&](ClusterId, const ClusterView& cluster) {
    for (std::size_t p = 0; p < cluster.size(); ++p) {
      const PatchHead& head = cluster.patch_head(p);
      if (head.inert) continue;
      const std::span<const double> mean = cluster.patch(p).e_of(0);
      const Spectrum e{mean[0], mean[1], mean[2]};
      sum.arrived += head.area * luminance(e);
      sum.leaving += head.area * luminance(head.exitance + head.reflectance * e);
      sum.absorbed += head.area * luminance((Spectrum{1} - head.reflectance) * e);
    }
  }));
  return sum;
}

Status note_unsolved(const std::string& name, const Status& why, Validation& v) {
  if (why.code() == Code::kStore) return why;
  v.cases.push_back(within(name, 0, std::numeric_limits<double>::quiet_NaN(), 0));
  v.examples.push_back(name + ": " + why.message());
  return {};
}

void note_end(const std::string& name, const SolveSummary& s, Validation& v) {
  if (s.exit_code == 0) return;
  char residual[32];
  std::snprintf(residual, sizeof residual, "%.3g", s.residual);
  v.examples.push_back(name + ": " + s.stop_reason + " after " + std::to_string(s.iterations) +
                       " gathers, at a residual of " + residual);
}

Status judge_illuminance(const std::string& name, SolvedScene& scene, const SurfaceProbe& probe,
                         double expected, double allowed, Validation& v) {
  const auto sample = scene.at(probe);
  if (!sample.ok()) return sample.status();
  const double found =
      *sample ? luminance((*sample)->irradiance) : std::numeric_limits<double>::quiet_NaN();
  v.cases.push_back(within(name, expected, found, allowed));
  if (!*sample) v.examples.push_back(name + ": no surface stands there");
  return {};
}

std::vector<SurfaceProbe> points_by_area(const GeneratedModel& model, int count) {
  std::vector<double> areas;
  for (const GeneratedFace& f : model.faces) areas.push_back(area(model.polygon(f)));
  std::mt19937 engine;  // its own fixed seed
  std::discrete_distribution<std::size_t> face(areas.begin(), areas.end());
  std::uniform_real_distribution<double> uniform;
  std::vector<SurfaceProbe> points;
  for (int i = 0; i < count; ++i) {
    const PolygonView polygon = model.polygon(model.faces[face(engine)]);
    const double pick = uniform(engine), s = uniform(engine), t = uniform(engine);
    points.push_back({point_in(polygon, pick, s, t), normalize(area_vector(polygon))});
  }
  return points;
}

}  // namespace atrium
