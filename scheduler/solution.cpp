#include "scheduler/solution.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "scheduler/leaves.h"
#include "scheduler/patch_grid.h"
#include "scheduler/run_model.h"
#include "scheduler/run_state.h"
#include "solver/basis.h"

namespace atrium {

struct Solution::Parts {
  RunModel run;
  std::string summary;
  std::unique_ptr<ClusterStore> store;
  ClusterPin pin;
  std::optional<PatchGrid> grid;
  std::unique_ptr<RayWorlds> worlds;
  std::unique_ptr<FreshGather> fresh;
};

Solution::Solution() : parts_(std::make_unique<Parts>()) {}
Solution::~Solution() { parts_->pin = {}; }

Result<std::unique_ptr<Solution>> Solution::open(const std::string& directory,
                                                 std::size_t arena_bytes) {
  namespace fs = std::filesystem;
  if (!fs::is_directory(directory))
    return Status(Code::kUsage, directory, "", "not a run directory",
                  "give the directory that atrium solve wrote with -o");
  StoreOptions options;
  options.arena_bytes = arena_bytes;
  Result<std::unique_ptr<ClusterStore>> store =
      ClusterStore::open(directory, options, OpenMode::kReadOnly);
  if (!store.ok()) return store.status();
  std::unique_ptr<Solution> s(new Solution);
  Parts& parts = *s->parts_;
  parts.store = std::move(store).value();
  Result<RunModel> run = load_run_model(*parts.store, directory);
  if (!run.ok()) return run.status();
  parts.run = std::move(run).value();
  RunFiles files(machine_disk(Io::kMmap), directory);
  const Result<RunState> state = run_state(parts.store->state(), directory);
  if (!state.ok()) return state.status();
  ATRIUM_RETURN_IF_ERROR(files.verify_all(state->sums));
  if (files.exists(RunFile::kSummary)) {
    Result<std::string> text = files.read(RunFile::kSummary);
    if (!text.ok()) return text.status();
    parts.summary = std::move(text).value();
  }
  return s;
}

const RunModel& Solution::run() const { return parts_->run; }
const std::string& Solution::summary_json() const { return parts_->summary; }

Result<ClusterView> Solution::cluster(ClusterId id) {
  parts_->pin = {};
  Result<ClusterPin> pin = parts_->store->read(record_id(RecordKind::kCluster, id.value));
  if (!pin.ok()) return pin.status();
  parts_->pin = std::move(pin).value();
  return ClusterView::parse(parts_->pin.bytes());
}

Status Solution::for_each_cluster(const std::function<void(ClusterId, const ClusterView&)>& visit) {
  for (std::size_t c = 0; c < parts_->run.model.clusters.size(); ++c) {
    const Result<ClusterView> view = cluster(ClusterId(c));
    if (!view.ok()) return view.status();
    visit(ClusterId(c), *view);
  }
  return {};
}

std::optional<PatchId> Solution::patch_at(const Vec3& x, const Vec3& normal,
                                          double tolerance) const {
  if (!parts_->grid || parts_->grid->margin() < tolerance)
    parts_->grid.emplace(parts_->run.model, parts_->run.bounds, tolerance);
  return parts_->grid->find(x, normal, tolerance);
}

CellId Solution::cell_at(const Vec3& x, const Vec3& normal) const {
  const Model& model = parts_->run.model;
  const double step = 10 * model.tolerance;
  const Vec3 at = x + step * normal;
  CellId best;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t c = 0; c < model.cells.size(); ++c) {
    const Cell& cell = model.cells[c];
    if (!cell.bounds.contains(at)) continue;
    const Vec3 e = cell.bounds.extent();
    const double volume = e.x * e.y * e.z;
    if (volume < smallest) {
      smallest = volume;
      best = CellId(c);
    }
  }
  return best;
}

Result<SurfaceSample> Solution::sample(PatchId id, const Vec3& x) {
  const Model& model = parts_->run.model;
  const Patch& patch = model.patches[id.value];
  const Result<ClusterView> view = cluster(patch.cluster);
  if (!view.ok()) return view.status();
  const PatchView tree = view->patch(id.value - model.clusters[patch.cluster.value].first_patch);
  const Vec2 p = tree.head->frame.to_plane(x);
  SurfaceSample s;
  s.irradiance = irradiance_at(tree, leaf_at(tree, p), p);
  s.reflectance = tree.head->reflectance;
  s.radiosity = tree.head->exitance + tree.head->reflectance * s.irradiance;
  s.cluster = patch.cluster;
  s.cell = cell_at(x, tree.head->frame.n);
  return s;
}

Result<std::vector<FreshIrradiance>> Solution::final_gather(std::span<const GatherPoint> points,
                                                            const FreshSettings& settings) {
  if (!parts_->fresh) {
    const Model& model = parts_->run.model;
    parts_->worlds = std::make_unique<RayWorlds>(model, RayUse::kAlways);
    parts_->fresh = std::make_unique<FreshGather>(model, *parts_->store, *parts_->worlds);
  }
  parts_->pin = {};
  const Result<BrightSources> bright = BrightSources::find(parts_->run.model, *parts_->store);
  if (!bright.ok()) return bright.status();
  return parts_->fresh->gather(*bright, points, settings);
}

Spectrum polynomial_at(const PatchView& patch, std::int32_t element, const Vec2& p) {
  const BasisValues phi =
      evaluate_basis(patch.basis_of(element), patch.elements[element], patch.order, p);
  const std::span<const double> e = patch.e_of(element);
  Spectrum sum{0};
  for (int a = 0; a < patch.k(); ++a)
    sum += phi[a] * Spectrum{e[3 * a], e[3 * a + 1], e[3 * a + 2]};
  return sum;
}

Spectrum irradiance_at(const PatchView& patch, std::int32_t element, const Vec2& p) {
  const Spectrum sum = polynomial_at(patch, element, p);
  // The basis rings below zero beside sharp shadows: clamped here, where it is shown.
  return {std::max(0.0, sum.x), std::max(0.0, sum.y), std::max(0.0, sum.z)};
}

}  // namespace atrium
