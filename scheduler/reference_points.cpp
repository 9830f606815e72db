#include "scheduler/reference_points.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "engine/cluster_record.h"
#include "scheduler/leaves.h"
#include "scheduler/run_files.h"
#include "scheduler/patch_grid.h"
#include "scheduler/solution.h"

namespace atrium {

namespace {

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream in(line);
  for (std::string f; std::getline(in, f, ',');) out.push_back(f);
  return out;
}

Status bad_line(const std::string& path, std::size_t line, const std::string& cause) {
  return Status(Code::kUsage, path, "line " + std::to_string(line), cause,
                "columns are x,y,z,nx,ny,nz,Er,Eg,Eb and optionally seEr,seEg,seEb");
}

// Where the wanted columns stand in the header.
struct Columns {
  std::array<int, 9> needed;
  std::array<int, 3> noise;
};

bool find_columns(const std::vector<std::string>& header, Columns& c) {
  const auto place = [&](const char* name) {
    const auto at = std::find(header.begin(), header.end(), name);
    return at == header.end() ? -1 : static_cast<int>(at - header.begin());
  };
  constexpr const char* kNeeded[] = {"x", "y", "z", "nx", "ny", "nz", "Er", "Eg", "Eb"};
  constexpr const char* kNoise[] = {"seEr", "seEg", "seEb"};
  bool all = true;
  for (int i = 0; i < 9; ++i) all &= (c.needed[i] = place(kNeeded[i])) >= 0;
  for (int i = 0; i < 3; ++i) c.noise[i] = place(kNoise[i]);
  return all;
}

bool number(const std::vector<std::string>& row, int column, double& x) {
  if (column < 0 || column >= static_cast<int>(row.size())) return false;
  char* end = nullptr;
  x = std::strtod(row[column].c_str(), &end);
  return end != row[column].c_str() && std::isfinite(x);
}

}  // namespace

Result<ReferencePoints> ReferencePoints::read(const std::string& path, const Scene& scene,
                                              const Model& model) {
  Result<std::string> text = read_text(machine_disk(Io::kMmap), path);
  if (!text.ok()) return Status(Code::kUsage, path, "", text.status().cause(), "check --reference");
  // As the reference's points are stated in the files' units: on a surface within this share of it.
  constexpr double kOnSurface = 1e-5;
  const double tolerance = kOnSurface * scene.bounds.diagonal();
  const PatchGrid grid(model, scene.bounds, tolerance);
  std::istringstream in(*text);
  Columns columns;
  ReferencePoints points;
  std::size_t line = 0;
  bool header = false;
  for (std::string row_text; std::getline(in, row_text);) {
    ++line;
    if (!row_text.empty() && row_text.back() == '\r') row_text.pop_back();
    if (row_text.empty() || row_text[0] == '#') continue;
    const std::vector<std::string> row = fields(row_text);
    if (!header) {
      if (!find_columns(row, columns)) return bad_line(path, line, "a column is missing");
      header = true;
      continue;
    }
    std::array<double, 9> v;
    for (int i = 0; i < 9; ++i)
      if (!number(row, columns.needed[i], v[i])) return bad_line(path, line, "not a number");
    Spectrum noise{0};
    for (int i = 0; i < 3; ++i) number(row, columns.noise[i], noise[i]);
    const Vec3 x = scene.frame.to_internal({v[0], v[1], v[2]});
    const std::optional<PatchId> patch = grid.find(x, {v[3], v[4], v[5]}, tolerance);
    if (!patch) continue;
    points.points_.push_back({x, *patch, luminance({v[6], v[7], v[8]}), luminance(noise)});
    points.mean_ += points.points_.back().truth;
  }
  if (points.points_.empty())
    return Status(Code::kUsage, path, "", "none of its points lies on a surface of the scene",
                  "check that it belongs to this scene and to --unit");
  points.mean_ /= static_cast<double>(points.points_.size());
  // By cluster, so that each record is read once.
  std::stable_sort(points.points_.begin(), points.points_.end(),
                   [](const Point& a, const Point& b) { return a.patch < b.patch; });
  return points;
}

Result<double> ReferencePoints::error(const Model& model, ClusterStore& store) const {
  double sum = 0;
  ClusterId at;
  ClusterPin pin;
  std::optional<ClusterView> view;
  for (const Point& p : points_) {
    const ClusterId cluster = model.patches[p.patch.value].cluster;
    if (cluster != at) {
      view.reset();
      pin = {};
      Result<ClusterPin> read = store.read(record_id(RecordKind::kCluster, cluster.value));
      if (!read.ok()) return read.status();
      pin = std::move(read).value();
      Result<ClusterView> parsed = ClusterView::parse(pin.bytes());
      if (!parsed.ok()) return parsed.status();
      view.emplace(*parsed);
      at = cluster;
    }
    const PatchView tree = view->patch(p.patch.value - model.clusters[cluster.value].first_patch);
    const Vec2 q = tree.head->frame.to_plane(p.x);
    const double scale = std::max(p.truth, mean_);
    const double d = (luminance(irradiance_at(tree, leaf_at(tree, q), q)) - p.truth) / scale;
    sum += d * d - (p.noise / scale) * (p.noise / scale);
  }
  return std::sqrt(std::max(0.0, sum / static_cast<double>(points_.size())));
}

}  // namespace atrium
