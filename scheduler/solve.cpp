#include "scheduler/solve.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>

#include "scheduler/gather_cluster.h"
#include "scheduler/history.h"
#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "scheduler/reference_points.h"
#include "scheduler/run_model.h"
#include "solver/element_tree.h"

namespace atrium {

namespace {

std::atomic<bool> stop_flag{false};

// Refinement goes from coarse to fine: each level's link threshold is this many times the last's,
// so that brightness is known roughly before it decides what is worth refining.
constexpr std::array<double, 3> kLevels{16, 4, 1};
// Link threshold of the last level ÷ error asked for: found on the scenes with references, so that what
// is asked for is about what the truth says.
constexpr double kThresholdOfError = 0.005;
// A level ends when the light still to come is below this share of all: coarse ones, and for the
// last relative to the error asked for.
constexpr double kCoarseRest = 0.01;
constexpr double kFineRestOfError = 1.0 / 50;
// So many sweeps in a row without progress, and none is to be expected. Links that are made anew each
// time are not quite the same each time: where there are such, the change stays at their noise, and
// progress is a change that falls by a tenth.
constexpr std::uint32_t kStalledSweeps = 30, kNoisySweeps = 6;
constexpr double kNoisyProgress = 0.9;
// Sources brighter than this many times the mean are lamps: they do not stand for their room.
constexpr double kLampOfMean = 8;

double now() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

double cpu_now() { return double(std::clock()) / CLOCKS_PER_SEC; }

std::uint64_t peak_rss() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return std::uint64_t(u.ru_maxrss) * 1024;
}

// Where the iteration stands: kept as the store's state, so that a run can go on.
struct Cursor {
  std::uint64_t iteration = 0;  // complete gathers to all clusters
  std::uint32_t level = 0;
  std::uint32_t sweep = 0;      // in this level
  double mean_irradiance = 0;   // lx
  double mean_radiosity = 0;    // lm/m²
  double last_change = 0;
  std::uint32_t done = 0;       // 1: converged
  std::uint32_t stalled = 0;    // sweeps in a row whose change did not fall
  double least_change = 0;      // of this level
};

// Sums over an iteration.
struct Sweep {
  PushPullSums sums;
  RefineCounters refined;
  std::uint64_t gathered = 0, elements = 0, links = 0;
  std::uint64_t working_set_bytes = 0, working_set_links = 0, working_set_elements = 0;
  std::uint64_t total_bytes = 0;
  double solver_seconds = 0;

  void add(const GatherReport& r) {
    sums.add(r.sums);
    refined.add(r.refined);
    ++gathered;
    elements += r.elements;
    links += r.links;
    working_set_bytes = std::max(working_set_bytes, r.working_set_bytes);
    working_set_links = std::max(working_set_links, r.links);
    working_set_elements = std::max(working_set_elements, r.working_set_elements);
    total_bytes += r.link_bytes + r.source_elements * sizeof(Element);
    solver_seconds += r.solver_seconds;
  }
};

enum class Stop { kNone, kConverged, kResidual, kIterations, kTime, kRequested, kStalled };

const char* reason(Stop s) {
  switch (s) {
    case Stop::kConverged: return "converged";
    case Stop::kResidual: return "residual reached";
    case Stop::kIterations: return "iteration limit";
    case Stop::kTime: return "time limit";
    case Stop::kRequested: return "stopped on request";
    case Stop::kStalled: return "no longer converging";
    case Stop::kNone: break;
  }
  return "";
}

int exit_code(Stop s) {
  if (s == Stop::kRequested) return static_cast<int>(Code::kStopped);
  if (s == Stop::kIterations || s == Stop::kTime || s == Stop::kStalled) return static_cast<int>(Code::kLimit);
  return 0;
}

// The radiosity scheduler: "the conceptual center of the system". [THFH94 §4]
class Scheduler {
 public:
  Scheduler(const SolveOptions& options, const ProgressCallback& progress, const LogCallback& log)
      : options_(options), progress_(progress), log_(log), start_(now()), cpu_start_(cpu_now()) {}

  Result<SolveSummary> run();

 private:
  std::string path(const char* name) const { return options_.run_directory + "/" + name; }
  Status make_run_directory();
  Status write_first_records();
  Status iterate();
  Status sweep();
  GatherTask task_for(ClusterId receiver);
  void settle(const GatherTask& task);
  void end_sweep(const StoreCounters& before);
  Status record_history(const StoreCounters& before, bool complete);
  bool limits_reached();
  Status finish();
  double rest_of_light(double change) const;
  bool stalled(double change);
  void say(const std::string& text) {
    if (log_) log_(text);
  }

  const SolveOptions& options_;
  const ProgressCallback& progress_;
  const LogCallback& log_;
  const double start_, cpu_start_;
  std::unique_ptr<ClusterStore> store_;
  std::optional<Prepared> prepared_;
  std::optional<ReferencePoints> reference_;
  std::unique_ptr<RayWorlds> worlds_;
  std::vector<ClusterId> order_;
  std::vector<std::vector<Braid>> kept_;  // by cluster; empty: not kept
  std::uint64_t kept_bytes_ = 0, keep_budget_ = 0;
  Cursor cursor_;
  Sweep sweep_;
  Stop stop_ = Stop::kNone;
  SolveSummary summary_;
  HistoryLine last_line_;
  double last_progress_ = 0, last_line_at_ = now();
};

Status Scheduler::make_run_directory() {
  namespace fs = std::filesystem;
  for (const std::string& f : options_.scene.files)
    if (!fs::exists(f))
      return Status(Code::kScene, f, "", "no such file", "check the path of the scene");
  const std::string toml = run_toml(options_);
  StoreOptions store;
  store.arena_bytes = options_.arena ? options_.arena : options_.memory / 4;
  store.policy = options_.policy;
  if (fs::exists(path("run.toml"))) {
    Result<std::string> there = read_text(path("run.toml"));
    if (!there.ok()) return there.status();
    if (*there != toml)
      return Status(Code::kUsage, options_.run_directory, "run.toml",
                    "the directory holds another run", "give another directory with -o");
    Result<std::unique_ptr<ClusterStore>> opened =
        ClusterStore::open(options_.run_directory, store, OpenMode::kReadWrite);
    if (opened.ok()) {
      store_ = std::move(opened).value();
      return {};
    }
    if (opened.status().code() != Code::kUsage) return opened.status();
  }
  Result<std::unique_ptr<ClusterStore>> created =
      ClusterStore::create(options_.run_directory, store);
  if (!created.ok()) return created.status();
  store_ = std::move(created).value();
  return write_text(path("run.toml"), toml);
}

// Every cluster's record, its blockers, and the model: the database before the first gather.
Status Scheduler::write_first_records() {
  const Model& model = prepared_->model;
  for (std::size_t c = 0; c < model.clusters.size(); ++c) {
    const Cluster& cluster = model.clusters[c];
    std::vector<PatchTree> trees;
    for (std::uint32_t i = 0; i < cluster.patch_count; ++i)
      trees.push_back(plant(model, prepared_->scene, PatchId(cluster.first_patch + i),
                            options_.basis));
    std::vector<std::byte> bytes(record_bytes(trees));
    write_record(static_cast<std::uint32_t>(c), trees, bytes);
    ATRIUM_RETURN_IF_ERROR(store_->create_record(record_id(RecordKind::kCluster, c), bytes));
    ATRIUM_RETURN_IF_ERROR(store_->create_record(record_id(RecordKind::kBlockers, c),
                                                 write_blockers(model, cluster)));
  }
  RunModel run;
  run.frame = prepared_->scene.frame;
  run.bounds = prepared_->scene.bounds;
  run.tolerance = prepared_->scene.tolerance;
  run.order = options_.basis;
  run.files = prepared_->scene.files;
  for (const Object& o : prepared_->scene.objects) run.object_names.push_back(o.name);
  for (const Material& m : prepared_->scene.materials) run.material_names.push_back(m.name);
  run.model = model;
  return store_run_model(run, *store_);
}

// Light still to come if each sweep adds q times what the last one did, as a share of all.
double Scheduler::rest_of_light(double change) const {
  if (cursor_.sweep == 0 || !(cursor_.last_change > 0)) return change > 0 ? 1 : 0;
  constexpr double kSlowest = 0.9999;
  const double q = std::clamp(change / cursor_.last_change, 0.0, kSlowest);
  return change * std::max(1.0, q / (1 - q));
}

GatherTask Scheduler::task_for(ClusterId receiver) {
  GatherTask t;
  t.receiver = receiver;
  std::vector<Braid>& kept = kept_[receiver.value];
  if (!kept.empty()) {
    t.linking = Linking::kUseKept;
    t.kept = &kept;
  } else if (options_.links != "discard" && kept_bytes_ < keep_budget_) {
    t.linking = Linking::kMakeAndKeep;
    t.kept = &kept;
  }
  t.refine.threshold = kThresholdOfError * options_.error * kLevels[cursor_.level];
  t.refine.mean_irradiance = cursor_.mean_irradiance;
  t.refine.ambient = cursor_.iteration == 0 ? 0.5 * cursor_.mean_irradiance : 0;
  t.refine.reference_area = prepared_->light.reference_area;
  t.refine.min_edge = prepared_->plan.min_edge;
  t.refine.tolerance = prepared_->model.tolerance;
  t.lamp_cap = kLampOfMean * cursor_.mean_radiosity;
  return t;
}

// Braids beyond the budget are discarded after all.
void Scheduler::settle(const GatherTask& task) {
  if (task.linking != Linking::kMakeAndKeep) return;
  std::uint64_t bytes = 0;
  for (const Braid& b : *task.kept) bytes += b.bytes();
  if (kept_bytes_ + bytes > keep_budget_)
    std::vector<Braid>().swap(*task.kept);
  else
    kept_bytes_ += bytes;
}

bool Scheduler::limits_reached() {
  if (stop_flag.load()) stop_ = Stop::kRequested;
  if (options_.time_limit > 0 && now() - start_ >= options_.time_limit) stop_ = Stop::kTime;
  return stop_ != Stop::kNone;
}

// One complete gather to every cluster.
Status Scheduler::sweep() {
  sweep_ = {};
  const StoreCounters before = store_->counters();
  const double began = now();
  for (const ClusterId receiver : order_) {
    if (limits_reached()) return record_history(before, false);
    const GatherTask task = task_for(receiver);
    Result<GatherReport> report = gather_cluster(prepared_->model, *store_, *worlds_, task);
    if (!report.ok()) return report.status();
    settle(task);
    sweep_.add(*report);
    const double t = now();
    if (progress_ && t - last_progress_ > 0.2) {
      last_progress_ = t;
      Progress p{cursor_.iteration + 1, sweep_.gathered, order_.size(), sweep_.elements,
                 sweep_.links, t - start_, last_line_.residual, -1};
      p.eta_seconds = (t - began) / sweep_.gathered * (order_.size() - sweep_.gathered);
      progress_(p);
    }
    if (t - last_line_at_ > 60) ATRIUM_RETURN_IF_ERROR(record_history(before, false));
  }
  ++cursor_.iteration;
  end_sweep(before);
  return record_history(before, true);
}

void Scheduler::end_sweep(const StoreCounters& before) {
  const PushPullSums& s = sweep_.sums;
  if (s.area > 0) {
    cursor_.mean_irradiance = s.flux_in / s.area;
    cursor_.mean_radiosity = luminance(s.emitted + s.reflected) / s.area;
  }
  summary_.iterations = cursor_.iteration;
  summary_.elements = sweep_.elements;
  summary_.links = sweep_.links;
  summary_.max_working_set_bytes = std::max(summary_.max_working_set_bytes, sweep_.working_set_bytes);
  summary_.max_working_set_links = std::max(summary_.max_working_set_links, sweep_.working_set_links);
  summary_.max_working_set_elements =
      std::max(summary_.max_working_set_elements, sweep_.working_set_elements);
  summary_.links_processed += sweep_.links;
  summary_.total_data_bytes += sweep_.total_bytes;
  summary_.flux_emitted = luminance(s.emitted);
  summary_.flux_absorbed = luminance(s.absorbed);
  summary_.flux_escaped = luminance(s.escaped);
  summary_.hit_ratio = (store_->counters() - before).hit_ratio();
}

Status Scheduler::record_history(const StoreCounters& before, bool complete) {
  const StoreCounters c = store_->counters() - before;
  HistoryLine h;
  h.seconds = now() - start_;
  h.cpu_seconds = cpu_now() - cpu_start_;
  h.iteration = cursor_.iteration + (complete ? 0 : 1);
  h.clusters_gathered = sweep_.gathered;
  const double norm = prepared_->light.exitance_norm;
  h.residual = norm > 0 ? std::sqrt(sweep_.sums.change2) / norm : 0;
  h.elements = sweep_.elements;
  h.links = sweep_.links;
  h.rays = sweep_.refined.rays;
  h.reads = c.reads;
  h.writes = c.writes;
  h.bytes_read = c.bytes_read;
  h.bytes_written = c.bytes_written;
  h.hit_ratio = c.hit_ratio();
  h.solver_seconds = sweep_.solver_seconds;
  h.io_seconds = h.stall_seconds = c.io_seconds;
  h.max_working_set_bytes = sweep_.working_set_bytes;
  h.peak_rss_bytes = peak_rss();
  if (complete && reference_) {
    Result<double> e = reference_->error(prepared_->model, *store_);
    if (!e.ok()) return e.status();
    h.error_true = summary_.error_true = *e;
  }
  last_line_ = h;
  last_line_at_ = now();
  if (complete) {
    summary_.residual = h.residual;
    summary_.solver_seconds += sweep_.solver_seconds;
  }
  char text[256];
  std::snprintf(text, sizeof text,
                "iteration %llu level %u: residual %.3g, %llu elements, %llu links, %llu rays, "
                "hit ratio %.3f, %.1f s",
                static_cast<unsigned long long>(h.iteration), cursor_.level, h.residual,
                static_cast<unsigned long long>(h.elements),
                static_cast<unsigned long long>(h.links), static_cast<unsigned long long>(h.rays),
                h.hit_ratio, h.seconds);
  say(text);
  ATRIUM_RETURN_IF_ERROR(append_line(path("run.log"), text));
  return append_line(path("history.jsonl"), history_json(h));
}

// Has the iteration stalled? change: of reflected flux, by the sweep that ended.
bool Scheduler::stalled(double change) {
  const bool noisy = sweep_.refined.kernels > 0;
  const double progress = (noisy ? kNoisyProgress : 1) * cursor_.least_change;
  const bool falls = cursor_.sweep <= 1 || change < progress;
  cursor_.stalled = falls ? 0 : cursor_.stalled + 1;
  if (falls) cursor_.least_change = change;
  return cursor_.stalled >= (noisy ? kNoisySweeps : kStalledSweeps);
}

// The loop over receivers "until convergence" [THFH94 §5.1], level by level.
Status Scheduler::iterate() {
  const std::uint64_t limit = options_.iterations;
  // Where iterations are counted out, each level gets its share of them.
  const std::uint64_t share = limit ? std::max<std::uint64_t>(1, limit / kLevels.size()) : 0;
  while (stop_ == Stop::kNone) {
    const bool last = cursor_.level + 1 == kLevels.size();
    ATRIUM_RETURN_IF_ERROR(sweep());
    if (stop_ != Stop::kNone) break;
    const PushPullSums& s = sweep_.sums;
    const double reflected = luminance(s.reflected);
    const double change = reflected > 0 ? s.change / reflected : 0;
    const double rest = rest_of_light(change);
    ++cursor_.sweep;
    cursor_.last_change = change;
    const bool no_progress = stalled(change);
    const bool settled = rest < (last ? kFineRestOfError * options_.error : kCoarseRest);
    if (last && options_.residual > 0 && last_line_.residual <= options_.residual)
      stop_ = Stop::kResidual;
    else if (last && options_.residual == 0 && settled)
      stop_ = Stop::kConverged;
    else if (limit && cursor_.iteration >= limit)
      stop_ = Stop::kIterations;
    else if (last && no_progress)
      stop_ = Stop::kStalled;
    else if (!last && (settled || (share && cursor_.sweep >= share))) {
      ++cursor_.level;
      cursor_.sweep = 0;
      for (std::vector<Braid>& b : kept_) std::vector<Braid>().swap(b);
      kept_bytes_ = 0;
    }
  }
  cursor_.done = stop_ == Stop::kConverged || stop_ == Stop::kResidual;
  return {};
}

Status Scheduler::finish() {
  std::array<std::byte, sizeof(Cursor)> state;
  std::memcpy(state.data(), &cursor_, sizeof cursor_);
  ATRIUM_RETURN_IF_ERROR(store_->checkpoint(state));
  const StoreCounters& c = store_->counters();
  summary_.reads = c.reads;
  summary_.writes = c.writes;
  summary_.evictions = c.evictions;
  summary_.bytes_read = c.bytes_read;
  summary_.bytes_written = c.bytes_written;
  summary_.io_seconds = summary_.stall_seconds = c.io_seconds;
  summary_.store_bytes = store_->live_bytes(RecordKind::kCluster);
  if (c.evictions == 0)
    summary_.left_out.push_back({"eviction", "everything fits into the arena"});
  summary_.total_seconds = now() - start_;
  summary_.peak_rss_bytes = peak_rss();
  summary_.stop_reason = reason(stop_);
  summary_.exit_code = exit_code(stop_);
  return write_text(path("summary.json"), summary_json(summary_));
}

Result<SolveSummary> Scheduler::run() {
  ATRIUM_RETURN_IF_ERROR(validate(options_));
  ATRIUM_RETURN_IF_ERROR(make_run_directory());
  Result<Prepared> prepared = prepare(options_);
  if (!prepared.ok()) return prepared.status();
  prepared_.emplace(std::move(prepared).value());
  for (const std::string& w : prepared_->plan.warnings) say("warning: " + w);
  const Model& model = prepared_->model;
  Result<std::vector<ClusterId>> order = make_order(options_.order, model, options_.seed);
  if (!order.ok()) return order.status();
  order_ = std::move(order).value();
  if (!options_.reference.empty()) {
    Result<ReferencePoints> points =
        ReferencePoints::read(options_.reference, prepared_->scene, model);
    if (!points.ok()) return points.status();
    reference_.emplace(std::move(points).value());
  }

  summary_.scene = prepared_->scene.files;
  summary_.patches = prepared_->scene.patches;
  summary_.lights = prepared_->scene.lights;
  summary_.clusters = model.clusters.size();
  summary_.cells = model.cells.size();
  summary_.portals = model.portals.size();
  summary_.left_out = prepared_->plan.left_out;
  summary_.threads = static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));

  cursor_.mean_irradiance = prepared_->light.irradiance;
  cursor_.mean_radiosity = prepared_->light.radiosity;
  if (store_->state().size() == sizeof(Cursor))
    std::memcpy(&cursor_, store_->state().data(), sizeof cursor_);
  else
    ATRIUM_RETURN_IF_ERROR(write_first_records());
  worlds_ = std::make_unique<RayWorlds>(model, *store_);
  kept_.resize(model.clusters.size());
  // Half of the memory holds links; that is a share of --memory and not of what the arena leaves,
  // so that the same links are kept whatever the arena.
  keep_budget_ = options_.links == "keep" ? ~std::uint64_t{0} : options_.memory / 2;
  if (cursor_.done) {
    stop_ = Stop::kConverged;
  } else {
    cursor_.sweep = 0;
    ATRIUM_RETURN_IF_ERROR(iterate());
  }
  ATRIUM_RETURN_IF_ERROR(finish());
  return summary_;
}

}  // namespace

void request_stop() { stop_flag.store(true); }

Result<SolveSummary> solve(const SolveOptions& options, const ProgressCallback& progress,
                           const LogCallback& log) {
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return Scheduler(options, progress, log).run();
}

}  // namespace atrium
