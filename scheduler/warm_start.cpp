#include "scheduler/warm_start.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <unordered_map>

#include "engine/cluster_record.h"
#include "scheduler/memory.h"
#include "scheduler/relight.h"
#include "scheduler/run_model.h"
#include "scheduler/stored_patches.h"
#include "solver/element_tree.h"
#include "solver/push_pull.h"

namespace atrium {

namespace {

// A cluster is gathered to where more than this share of the error asked for, relative to the mean,
// comes to a unit of it. Beside what links get wrong, which is as much as was asked for at the
// most, the shape of what comes so is little: squares add up.
constexpr double kReaching = 1.0 / 4;

// The coarse system's word on how much light an edit leaves is not taken below this share.
constexpr double kDimmest = 1e-3;

// Bytes of arena for the old model's pieces; clusters are streamed past it.
constexpr std::size_t kArena = 4 * kRunModelPiece;

Status refuse(const std::string& directory, const std::string& why, const std::string& remedy) {
  return Status(Code::kUsage, directory, "--from", why, remedy);
}

// Bytes that are the same for the same side of the same surface.
std::uint64_t content_of(const Model& model, const Patch& patch) {
  const std::uint64_t outline = hash_bytes(std::as_bytes(model.polygon(patch)));
  return outline ^ patch.inert;
}

bool same_side(const Model& a, const Patch& p, const Model& b, const Patch& q) {
  const PolygonView x = a.polygon(p), y = b.polygon(q);
  return p.inert == q.inert && x.size() == y.size() &&
         std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
}

bool same_frame(const SceneFrame& a, const SceneFrame& b) { return a.origin == b.origin; }

bool same_contacts(std::span<const Segment2> a, std::span<const Segment2> b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

// What a patch adds to the sums over all, by its mean.
PushPullSums sums_of(const PatchHead& head, const Spectrum& irradiance) {
  PushPullSums s;
  if (head.inert) return s;
  const Spectrum e = head.area * irradiance;
  s.area = head.area;
  s.flux_in = luminance(e);
  s.absorbed = (Spectrum{1} - head.reflectance) * e;
  s.reflected = head.reflectance * e;
  s.emitted = head.area * head.exitance;
  if (head.escape > 0) s.escaped = head.escape * (s.reflected + s.emitted);
  return s;
}

// Elements and light of the same patch as it was, and what of its directions leaves the scene
// unless that is to be measured anew.
void take_over(const PatchTree& was, bool sees_anew, PatchTree& tree) {
  PatchHead head = tree.head;
  if (!sees_anew) head.escape = was.head.escape;
  tree = was;
  tree.head = head;
}

Status put_in_pending(ClusterStore& store, ClusterId id, Equilibrium& equilibrium) {
  Result<ClusterEdit> edit = store.edit(record_id(RecordKind::kCluster, id.value));
  if (!edit.ok()) return edit.status();
  const Result<ClusterView> before = ClusterView::parse(edit->bytes());
  if (!before.ok()) return before.status();
  relight(*before, *edit, equilibrium.pending(id));
  equilibrium.put_in(id);
  return {};
}

}  // namespace

Result<std::unique_ptr<WarmStart>> WarmStart::open(const SolveOptions& options,
                                                   const Prepared& prepared) {
  std::unique_ptr<WarmStart> warm(new WarmStart(options, prepared));
  ATRIUM_RETURN_IF_ERROR(warm->open_run());
  warm->match_patches();
  warm->match_clusters();
  ATRIUM_RETURN_IF_ERROR(warm->compare());
  warm->look_for_moved();
  warm->forget_what_was_seen();
  return warm;
}

Status WarmStart::open_run() {
  const std::string& from = options_.from;
  if (!std::filesystem::is_directory(from) && options_.disk == nullptr)
    return refuse(from, "not a run directory", "give the directory of the run before the edit");
  StoreOptions options;
  options.arena_bytes = kArena;
  options.disk = options_.disk;
  auto store = ClusterStore::open(from, options, OpenMode::kReadOnly);
  if (!store.ok()) return store.status();
  store_ = std::move(store).value();
  const Result<RunState> state = run_state(store_->state(), from);
  if (!state.ok()) return state.status();
  state_ = *state;
  if (!state_.cursor.done)
    return refuse(from, "the run has not come to an end of its own",
                  "resume it first, or solve without --from");
  const ErrorEstimate& found = state_.figures.estimate;
  if (options_.error < state_.error_asked && (found.points == 0 || options_.error < found.error))
    return refuse(from, "the run is less exact than what is asked for",
                  "ask for no more than it did, or solve without --from");
  Result<RunModel> run = load_run_model(*store_, from);
  if (!run.ok()) return run.status();
  run_ = std::move(run).value();
  smallest_memory_ = prepared_.plan.smallest_memory + bytes_of(run_.model);
  if (options_.memory < smallest_memory_)
    return budget_too_small("--memory", options_.memory, smallest_memory_);
  if (run_.order != options_.basis)
    return refuse(from, "the run is of basis " + std::to_string(run_.order),
                  "give --basis " + std::to_string(run_.order) + ", or solve without --from");
  units_.emplace(run_.model, std::span<const ClusterId>());
  return {};
}

void WarmStart::match_patches() {
  origins_.resize(model_.patches.size());
  if (!same_frame(run_.frame, prepared_.scene.frame)) return;
  const Model& old = run_.model;
  std::unordered_map<std::uint64_t, PatchId> by_content;
  for (std::size_t p = 0; p < old.patches.size(); ++p)
    by_content.emplace(content_of(old, old.patches[p]), PatchId(p));
  for (std::size_t p = 0; p < origins_.size(); ++p) {
    const auto found = by_content.find(content_of(model_, model_.patches[p]));
    if (found == by_content.end()) continue;
    if (same_side(model_, model_.patches[p], old, old.patches[found->second.value]))
      origins_[p].before = found->second;
  }
}

// A cluster has its shape still where it is of the same patches in the same order.
void WarmStart::match_clusters() {
  const Model& old = run_.model;
  same_shape_as_.resize(model_.clusters.size());
  now_.resize(old.clusters.size());
  for (std::size_t c = 0; c < model_.clusters.size(); ++c) {
    const Cluster& cluster = model_.clusters[c];
    const PatchId first = origins_[cluster.first_patch].before;
    if (!first.valid()) continue;
    const ClusterId id = old.patches[first.value].cluster;
    const Cluster& before = old.clusters[id.value];
    bool same = first.value == before.first_patch && cluster.patch_count == before.patch_count;
    for (std::uint32_t i = 0; same && i < cluster.patch_count; ++i)
      same = origins_[cluster.first_patch + i].before == PatchId(first.value + i);
    if (!same) continue;
    same_shape_as_[c] = id;
    now_[id.value] = ClusterId(c);
  }
}

// The old record that holds a patch: valid until the next call.
Result<const ClusterView*> WarmStart::cluster_before(PatchId patch) {
  const ClusterId cluster = run_.model.patches[patch.value].cluster;
  if (view_ && read_ == cluster) return &*view_;
  view_.reset();
  const auto record = store_->stream_in(record_id(RecordKind::kCluster, cluster.value));
  if (!record.ok()) return record.status();
  const Result<ClusterView> view = ClusterView::parse(*record);
  if (!view.ok()) return view.status();
  view_ = *view;
  read_ = cluster;
  return &*view_;
}

Status WarmStart::compare() {
  changed_.assign(model_.clusters.size(), false);
  for (std::uint32_t p = 0; p < origins_.size(); ++p) {
    const ClusterView* before = nullptr;
    if (origins_[p].before.valid()) {
      const Result<const ClusterView*> read = cluster_before(origins_[p].before);
      if (!read.ok()) return read.status();
      before = *read;
    }
    compare(p, plant(model_, prepared_.scene, PatchId(p), options_.basis), before);
  }
  return {};
}

// before: null where the patch is new, which is taken to be lit as all is in the mean.
void WarmStart::compare(std::uint32_t patch, const PatchTree& planted, const ClusterView* before) {
  Origin& origin = origins_[patch];
  const std::uint32_t cluster = model_.patches[patch].cluster.value;
  PatchHead head = planted.head;
  Spectrum e{state_.cursor.mean_irradiance};
  bool repainted = false;
  if (before) {
    const Model& old = run_.model;
    const Patch& was = old.patches[origin.before.value];
    const std::size_t local = origin.before.value - old.clusters[was.cluster.value].first_patch;
    const PatchHead& painted = before->patch_head(local);
    e = mean_irradiance(before->patch(local), 0);
    head.escape = painted.escape;
    origin.touched = !same_contacts(planted.contacts, before->contacts(local));
    repainted =
        painted.reflectance != head.reflectance || painted.exitance != head.exitance;
    origin.change = head.exitance - painted.exitance +
                    (head.reflectance - painted.reflectance) * e;
    ++kept_.patches_kept;
    if (!origin.touched) kept_.elements_kept += before->patch(local).elements.size();
  }
  light_.add(sums_of(head, e));
  if (!before || origin.touched || repainted) changed_[cluster] = true;
}

void WarmStart::see_anew(std::span<const ClusterId> clusters) {
  for (const ClusterId c : clusters) sees_anew_[c.value] = true;
}

// What a shape that is new may be seen from, and what a shape that is gone was.
void WarmStart::look_for_moved() {
  sees_anew_.assign(model_.clusters.size(), false);
  for (std::size_t c = 0; c < model_.clusters.size(); ++c) {
    const Cluster& cluster = model_.clusters[c];
    const auto own = std::span(origins_).subspan(cluster.first_patch, cluster.patch_count);
    if (std::ranges::any_of(own, &Origin::touched)) sees_anew_[c] = true;
    if (same_shape_as_[c].valid()) continue;
    changed_[c] = sees_anew_[c] = true;
    see_anew(model_.visible[c]);
  }
  for (std::size_t c = 0; c < now_.size(); ++c) {
    if (now_[c].valid()) continue;
    for (const ClusterId s : run_.model.visible[c])
      if (now_[s.value].valid()) sees_anew_[now_[s.value].value] = true;
  }
  kept_.clusters_changed = std::uint64_t(std::ranges::count(changed_, true));
}

// Before the arena fills.
void WarmStart::forget_what_was_seen() {
  Model left;
  left.patches = std::move(run_.model.patches);
  left.clusters = std::move(run_.model.clusters);
  run_.model = std::move(left);
}

// A tree that begins with one element: lit as its patch was, or as all is in the mean.
PatchTree WarmStart::plant_anew(std::uint32_t patch) const {
  PatchTree tree = plant(model_, prepared_.scene, PatchId(patch), options_.basis);
  if (!tree.head.inert) add_everywhere(tree, Spectrum{state_.cursor.mean_irradiance});
  return tree;
}

Result<std::vector<PatchTree>> WarmStart::trees_of(ClusterId id) {
  const Cluster& cluster = model_.clusters[id.value];
  std::vector<PatchTree> trees, old;
  ClusterId from;  // of `old`
  for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count; ++p) {
    PatchTree tree = plant_anew(p);
    const Origin& origin = origins_[p];
    if (origin.before.valid()) {
      const Result<const ClusterView*> read = cluster_before(origin.before);
      if (!read.ok()) return read.status();
      if (from != read_) old = read_record(**read);
      from = read_;
      const PatchTree& was =
          old[origin.before.value - run_.model.clusters[read_.value].first_patch];
      if (origin.touched)
        tree.e.assign(was.e.begin(), was.e.begin() + std::ptrdiff_t(tree.e.size()));
      else
        take_over(was, sees_anew_[id.value], tree);
    }
    trees.push_back(std::move(tree));
  }
  return trees;
}

std::vector<UnitEdit> WarmStart::edits(const Equilibrium& equilibrium) const {
  std::vector<UnitEdit> edits(equilibrium.units());
  for (std::size_t c = 0; c < model_.clusters.size(); ++c) {
    if (!same_shape_as_[c].valid()) continue;
    const std::span<const std::uint32_t> units = equilibrium.units_of(ClusterId(c));
    const std::span<const std::uint32_t> before = units_->units_of(same_shape_as_[c]);
    for (std::size_t i = 0; i < units.size(); ++i) {
      const std::uint32_t p = model_.clusters[c].first_patch + std::uint32_t(i);
      if (model_.patches[p].inert) continue;
      UnitEdit& edit = edits[units[i]];
      const Material& paint = prepared_.scene.materials[model_.patches[p].material.value];
      const double share = area(model_.polygon(model_.patches[p])) / equilibrium.areas()[units[i]];
      edit.before = before[i];
      edit.reflectance += share * paint.reflectance;
      edit.change += share * origins_[p].change;
    }
  }
  return edits;
}

Status WarmStart::begin(Equilibrium& equilibrium, Cursor& cursor) const {
  if (!takes_over()) return {};
  ATRIUM_RETURN_IF_ERROR(
      equilibrium.take_over(*store_, units_->units(), edits(equilibrium)));
  const double pending =
      std::max(kDimmest, 1 + equilibrium.flux_pending() / light_.flux_in);
  const Cursor& old = state_.cursor;
  cursor.level = old.level;
  cursor.threshold = old.threshold;
  cursor.tightened = old.tightened;
  cursor.mean_irradiance = pending * light_.flux_in / light_.area;
  cursor.mean_radiosity = luminance(light_.emitted + pending * light_.reflected) / light_.area;
  std::uint64_t reached =
      reach_further(options_, model_, cursor.mean_irradiance, equilibrium);
  for (std::size_t c = 0; c < sees_anew_.size(); ++c) {
    if (!sees_anew_[c]) continue;
    equilibrium.reach(ClusterId(c));
    ++reached;
  }
  cursor.to_mend = reached > 0 && old.mended;
  if (reached > 0) return {};
  cursor.phase = Phase::kJudge;
  cursor.mended = old.mended;
  cursor.rest = 0;
  cursor.unseen = std::abs(equilibrium.flux_pending()) / light_.flux_in;
  return {};
}

WarmFigures WarmStart::figures(const Equilibrium& equilibrium) const {
  WarmFigures f = kept_;
  for (std::size_t c = 0; c < model_.clusters.size(); ++c)
    f.clusters_reached += equilibrium.reached(ClusterId(c)) != Reached::kNot;
  return f;
}

std::string in_words(const WarmFigures& f, const Plan& plan) {
  const auto of = [](std::uint64_t part, std::uint64_t whole, const char* what) {
    return std::to_string(part) + " of " + std::to_string(whole) + " " + what;
  };
  return "kept " + of(f.patches_kept, plan.patches, "patches") + " and " +
         std::to_string(f.elements_kept) + " elements; " +
         of(f.clusters_changed, plan.clusters, "clusters changed") + ", " +
         std::to_string(f.clusters_reached) + " to be gathered to";
}

Result<GatherReport> at_rest(ClusterStore& store, ClusterId cluster) {
  const Result<ClusterPin> pin = store.read(record_id(RecordKind::kCluster, cluster.value));
  if (!pin.ok()) return pin.status();
  const Result<ClusterView> view = ClusterView::parse(pin->bytes());
  if (!view.ok()) return view.status();
  GatherReport report;
  report.elements = view->head().elements;
  for (std::size_t p = 0; p < view->size(); ++p)
    report.sums.add(sums_of(view->patch_head(p), mean_irradiance(view->patch(p), 0)));
  return report;
}

std::uint64_t reach_further(const SolveOptions& options, const Model& model,
                            double mean_irradiance, Equilibrium& equilibrium) {
  const double least = kReaching * options.error * mean_irradiance;
  std::uint64_t reached = 0;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    const ClusterId id(c);
    if (equilibrium.reached(id) != Reached::kNot || equilibrium.come_by_itself(id) <= least)
      continue;
    equilibrium.reach(id);
    ++reached;
  }
  return reached;
}

Status put_in_pending(ClusterStore& store, const Model& model, Equilibrium& equilibrium) {
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    const ClusterId id(c);
    if (equilibrium.reached(id) != Reached::kNow && equilibrium.anything_pending(id))
      ATRIUM_RETURN_IF_ERROR(put_in_pending(store, id, equilibrium));
  }
  return {};
}

}  // namespace atrium
