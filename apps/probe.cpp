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
constexpr std::uint64_t kMostDirections = 1u << 20;  // a point's rays are held at once

struct ProbeOptions {
  std::vector<std::string> words;  // RUN, then the points
  std::string output;
  int directions = 0;  // of --final-gather; 0: read off the elements
};

// Where the points lie, looked up once, and what is read off there.
struct Places {
  std::vector<Vec3> x, normal;  // internal frame; unit
  std::vector<std::optional<PatchId>> patch;
  std::vector<SurfaceSample> sample;  // of those on a patch
};

Places find_places(const Solution& solution, const std::vector<ProbePoint>& points) {
  const RunModel& run = solution.run();
  const double tolerance = std::max(run.tolerance, kOnSurface * run.bounds.diagonal());
  Places places;
  for (const ProbePoint& p : points) {
    places.x.push_back(run.frame.to_internal(p.x));
    places.normal.push_back(normalize(p.normal));
    places.patch.push_back(solution.patch_at(places.x.back(), places.normal.back(), tolerance));
  }
  return places;
}

// Cluster by cluster, so that each record is read once.
Status read_elements(Solution& solution, Places& places) {
  std::vector<std::size_t> sequence(places.x.size());
  std::iota(sequence.begin(), sequence.end(), 0);
  // Patches of a cluster are contiguous.
  std::stable_sort(sequence.begin(), sequence.end(),
                   [&](std::size_t a, std::size_t b) { return places.patch[a] < places.patch[b]; });
  places.sample.resize(places.x.size());
  for (const std::size_t i : sequence) {
    if (!places.patch[i]) continue;
    Result<SurfaceSample> sample = solution.sample(*places.patch[i], places.x[i]);
    if (!sample.ok()) return sample.status();
    places.sample[i] = std::move(sample).value();
  }
  return {};
}

// Where that is asked for, and in the air, where there is nothing to read E off.
Status gather_afresh(Solution& solution, int directions, Places& places) {
  std::vector<GatherPoint> points;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < places.x.size(); ++i) {
    if (directions == 0 && places.patch[i]) continue;
    points.push_back({places.x[i], places.normal[i], places.sample[i].cluster});
    numbers.push_back(i);
  }
  if (points.empty()) return {};
  FreshSettings settings;
  settings.directions = directions == 0 ? kFreeDirections : directions;
  settings.replicates = 1;
  const auto gathered = solution.final_gather(points, settings);
  if (!gathered.ok()) return gathered.status();
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    SurfaceSample& sample = places.sample[numbers[k]];
    sample.radiosity += sample.reflectance * ((*gathered)[k].mean - sample.irradiance);
    sample.irradiance = (*gathered)[k].mean;
  }
  return {};
}

Result<std::vector<ProbeAnswer>> probe_points(Solution& solution,
                                              const std::vector<ProbePoint>& points,
                                              int directions) {
  Places places = find_places(solution, points);
  ATRIUM_RETURN_IF_ERROR(read_elements(solution, places));
  ATRIUM_RETURN_IF_ERROR(gather_afresh(solution, directions, places));
  std::vector<ProbeAnswer> answers(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const SurfaceSample& s = places.sample[i];
    answers[i] = {s.irradiance, std::nullopt, s.cluster, s.cell};
    if (places.patch[i]) answers[i].radiosity = s.radiosity;
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

Result<int> run_probe(const ProbeOptions& probe, const Global& global) {
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
  auto probe = std::make_shared<ProbeOptions>();
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
