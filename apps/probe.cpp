// atrium probe RUN [POINTS.csv|-]: the solution at points.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <numeric>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/points.h"
#include "apps/report_json.h"
#include "scheduler/solution.h"

namespace atrium {
namespace {

// A point this share of the scene's size off a surface still belongs to it.
constexpr double kOnSurface = 1e-6;
// Directions for points on no surface, where there is nothing to read E off.
constexpr int kFreeDirections = 4096;
constexpr std::uint64_t kMostDirections = 1u << 24;

struct Probe {
  std::vector<std::string> words;  // RUN, then the points
  std::string output;
  int directions = 0;  // of --final-gather; 0: read off the elements
};

Status probe_on_patch(Solution& solution, PatchId patch, const Vec3& x, const Vec3& normal,
                      int directions, ProbeAnswer& answer) {
  const Result<SurfaceSample> sample = solution.sample(patch, x);
  if (!sample.ok()) return sample.status();
  answer.irradiance = sample->irradiance;
  answer.radiosity = sample->radiosity;
  answer.cluster = sample->cluster;
  answer.cell = sample->cell;
  if (directions == 0) return {};
  const Result<Spectrum> gathered = solution.final_gather(x, normal, directions);
  if (!gathered.ok()) return gathered.status();
  const Result<ClusterView> record = solution.cluster(sample->cluster);
  if (!record.ok()) return record.status();
  const std::uint32_t first = solution.run().model.clusters[sample->cluster.value].first_patch;
  const PatchHead& head = record->patch_head(patch.value - first);
  answer.irradiance = *gathered;
  answer.radiosity = head.exitance + head.reflectance * *gathered;
  return {};
}

Status probe_in_air(Solution& solution, const Vec3& x, const Vec3& normal, int directions,
                    ProbeAnswer& answer) {
  const Result<Spectrum> gathered =
      solution.final_gather(x, normal, directions == 0 ? kFreeDirections : directions);
  if (!gathered.ok()) return gathered.status();
  answer.irradiance = *gathered;
  return {};
}

// Answers in the points' order; looked up cluster by cluster, so that each record is read once.
Result<std::vector<ProbeAnswer>> probe_points(Solution& solution,
                                              const std::vector<ProbePoint>& points,
                                              int directions) {
  const RunModel& run = solution.run();
  const double tolerance = std::max(run.tolerance, kOnSurface * run.bounds.diagonal());
  std::vector<std::optional<PatchId>> patches;
  for (const ProbePoint& p : points)
    patches.push_back(
        solution.patch_at(run.frame.to_internal(p.x), normalize(p.normal), tolerance));
  std::vector<std::size_t> sequence(points.size());
  std::iota(sequence.begin(), sequence.end(), 0);
  // Patches of a cluster are contiguous; points in the air come first.
  std::stable_sort(sequence.begin(), sequence.end(),
                   [&](std::size_t a, std::size_t b) { return patches[a] < patches[b]; });
  std::vector<ProbeAnswer> answers(points.size());
  for (const std::size_t i : sequence) {
    const Vec3 x = run.frame.to_internal(points[i].x);
    const Vec3 normal = normalize(points[i].normal);
    ATRIUM_RETURN_IF_ERROR(
        patches[i] ? probe_on_patch(solution, *patches[i], x, normal, directions, answers[i])
                   : probe_in_air(solution, x, normal, directions, answers[i]));
  }
  return answers;
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

void append(std::string& line, const Vec3& v) {
  for (int i = 0; i < 3; ++i) line += number(v[i]) + ",";
}

std::string id_text(std::uint32_t id, bool valid) { return valid ? std::to_string(id) : "-1"; }

std::string csv(const std::vector<ProbePoint>& points, const std::vector<ProbeAnswer>& answers) {
  std::string text = "x,y,z,nx,ny,nz,Er,Eg,Eb,Br,Bg,Bb,cluster,cell\n";
  for (std::size_t i = 0; i < points.size(); ++i) {
    const ProbeAnswer& a = answers[i];
    append(text, points[i].x);
    append(text, points[i].normal);
    append(text, a.irradiance);
    if (a.radiosity)
      append(text, *a.radiosity);
    else
      text += ",,,";
    text += id_text(a.cluster.value, a.cluster.valid()) + "," +
            id_text(a.cell.value, a.cell.valid()) + "\n";
  }
  return text;
}

Result<int> run_probe(const Probe& probe, const Global& global) {
  const std::string file = probe.words.size() > 1 ? probe.words[1] : "-";
  const Result<std::string> text = read_input(file);
  if (!text.ok()) return text.status();
  const auto points = parse_points(*text, file == "-" ? "stdin" : file);
  if (!points.ok()) return points.status();
  auto solution = Solution::open(probe.words[0], kReadingArena);
  if (!solution.ok()) return solution.status();
  const auto answers = probe_points(**solution, *points, probe.directions);
  if (!answers.ok()) return answers.status();
  ATRIUM_RETURN_IF_ERROR(write_output(
      probe.output, {global.json ? probe_json(*points, *answers) : csv(*points, *answers)}));
  return 0;
}

}  // namespace

Command probe_command() {
  auto probe = std::make_shared<Probe>();
  Command command{"probe", "the solution at points", {}, {}};
  command.options.argument("RUN", "a run directory; then a file of points, or - for stdin", 1, 2,
                           probe->words);
  command.options.output("where the answers go (stdout)", probe->output);
  command.options.count(
      "final-gather", "gather E afresh with so many directions", 1, kMostDirections,
      [p = probe.get()](std::uint64_t n) { p->directions = static_cast<int>(n); });
  command.run = [probe](const Global& global, Console&) { return run_probe(*probe, global); };
  return command;
}

}  // namespace atrium
