#include "scheduler/solve.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/stopwatch.h"
#include "scheduler/first_records.h"
#include "scheduler/gather_cluster.h"
#include "scheduler/levels.h"
#include "scheduler/local_pass.h"
#include "scheduler/memory.h"
#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "scheduler/reference_points.h"
#include "scheduler/run_directory.h"
#include "scheduler/run_report.h"

namespace atrium {

namespace {

std::atomic<bool> stop_flag{false}, checkpoint_flag{false};

// A gather across kept links takes so many times what it changes: what the coarse units do not tell
// falls to .2 (a cube) or .5 (Cornell) from sweep to sweep without, to .2 or .35 with it. Above 1.3
// the cube takes more sweeps than it saves elsewhere.
constexpr double kOver = 1.25;
// Sources brighter than this many times the mean are lamps: they do not stand for their room.
constexpr double kLampOfMean = 8;

constexpr RecordId kEquilibriumRecord = record_id(RecordKind::kEquilibrium, 0);

// Requests whose records are foreseen at a time; what is needed next is among them.
constexpr std::uint64_t kForesight = 1 << 16;

// The radiosity scheduler: "the conceptual center of the system". [THFH94 §4]
// It walks from cluster to cluster, sweep by sweep. What comes after a sweep is for levels.h to
// say, and run_report.h tells of it.
class Scheduler {
 public:
  Scheduler(const SolveOptions& options, const ProgressCallback& progress, const LogCallback& log)
      : options_(options), directory_(options, log), report_(directory_, progress, log) {}

  Result<SolveSummary> run();

 private:
  // The run on disk.
  Status open_run();
  Status take_up_run();
  Status checkpoint();
  Status checkpoint_if_due();
  Status finish();

  // The iteration.
  Status prepare_all();
  Status iterate();
  Status sweep();
  Result<GatherReport> gather_to(ClusterId receiver);
  void end_sweep();
  Status judge();
  void follow(const Next& next);
  GatherTask task_for(ClusterId receiver);
  void foresee_more();
  void forget_foreseen();
  bool limits_reached();
  Status fit_links(std::uint64_t beside = 0);
  double light_with_pending() const;
  double residual() const;
  SweepOutcome outcome() const;

  // How exact it is, for the history and to be judged by.
  Status record_history(std::uint32_t level, bool complete);
  Status look_at_error();
  SolveSummary& summary() { return report_.summary(); }

  const SolveOptions& options_;
  RunDirectory directory_;
  RunReport report_;
  std::uint64_t model_hash_ = 0;
  std::optional<Prepared> prepared_;
  std::optional<ReferencePoints> reference_;
  std::unique_ptr<RayWorlds> worlds_;
  std::unique_ptr<FreshGather> fresh_;
  std::optional<BrightSources> bright_;  // of the solution that the local pass measures
  std::vector<ClusterId> order_;
  std::unique_ptr<KeptLinks> links_;
  std::optional<Equilibrium> equilibrium_;
  Cursor cursor_;
  Sweep sweep_;
  std::uint64_t foreseen_ahead_ = 0;  // gathers after the one that comes next
  Stop stop_ = Stop::kNone;
  bool summary_written_ = false;  // of this end
  double last_checkpoint_ = now();
};

// The run directory is there before anything else.
Status Scheduler::open_run() {
  for (const std::string& f : options_.scene.files)
    if (!std::filesystem::exists(f))
      return Status(Code::kScene, f, "", "no such file", "check the path of the scene");
  ATRIUM_RETURN_IF_ERROR(directory_.open());
  return report_.show(cursor_, sweep_, true);
}

// From the first records, or from where an earlier process left it.
Status Scheduler::take_up_run() {
  ATRIUM_RETURN_IF_ERROR(directory_.reopen(prepared_->plan.arena));
  ATRIUM_RETURN_IF_ERROR(directory_.begin_trace());
  model_hash_ = fingerprint(prepared_->scene, prepared_->model);
  const RunState& earlier = directory_.earlier();
  if (!earlier.begun) {
    ATRIUM_RETURN_IF_ERROR(directory_.see_to_disk(prepared_->plan));
    ATRIUM_RETURN_IF_ERROR(write_first_records(*prepared_, options_.basis, directory_.store()));
    ATRIUM_RETURN_IF_ERROR(report_.log_gaps(prepared_->plan.closed_gaps));
    return checkpoint();
  }
  if (earlier.model_hash != model_hash_)
    return Status(
        Code::kUsage, options_.scene.files.front(), "",
        "the scene is not the one that the run in " + options_.run_directory + " was begun with",
        "give back the scene as it was, or solve into another directory");
  cursor_ = earlier.cursor;
  sweep_ = earlier.sweep;
  if (directory_.store().contains(kEquilibriumRecord)) {
    const auto record = directory_.store().stream_in(kEquilibriumRecord);
    if (!record.ok()) return record.status();
    ATRIUM_RETURN_IF_ERROR(equilibrium_->restore(*record));
  }
  report_.take_up(earlier);
  return {};
}

// Between two gathers: all of the solve that is not a function of the scene and the options.
Status Scheduler::checkpoint() {
  if (links_ && !cursor_.done) {
    ATRIUM_RETURN_IF_ERROR(links_->save());
    constexpr std::uint64_t kImages = 2;  // of the coarse system: as bytes, and as a record
    ATRIUM_RETURN_IF_ERROR(fit_links(kImages * equilibrium_->bytes()));
    ATRIUM_RETURN_IF_ERROR(
        directory_.store().stream_out(kEquilibriumRecord, equilibrium_->saved()));
  }
  RunState state;
  state.begun = 1;
  state.model_hash = model_hash_;
  state.cursor = cursor_;
  state.sweep = sweep_;
  report_.count_checkpoint(state);
  ATRIUM_RETURN_IF_ERROR(directory_.checkpoint(state, stop_ == Stop::kNone || summary_written_));
  last_checkpoint_ = now();
  report_.checkpointed();
  return {};
}

Status Scheduler::checkpoint_if_due() {
  const bool asked = checkpoint_flag.exchange(false);
  if (!asked && now() - last_checkpoint_ < options_.checkpoint_every) return {};
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  const ClusterStore& store = directory_.store();
  return report_.log("checkpoint of epoch " + std::to_string(store.epoch()) + ": " +
                     std::to_string(store.live_bytes()) + " bytes live, " +
                     std::to_string(store.allocated_bytes()) + " allocated");
}

// All irradiance, what the coarse system has found to be still to come with it, as a multiple of
// what is stored.
double Scheduler::light_with_pending() const {
  const double stored = sweep_.sums.flux_in;
  return stored > 0 ? 1 + std::max(0.0, equilibrium_->flux_pending()) / stored : 1;
}

GatherTask Scheduler::task_for(ClusterId receiver) {
  GatherTask t;
  t.receiver = receiver;
  t.links = links_.get();
  t.equilibrium = &*equilibrium_;
  if (options_.links != "discard")
    t.linking = cursor_.sweep > 0 ? Linking::kUseKept : Linking::kMakeAndKeep;
  t.refine.threshold = link_threshold(cursor_, options_);
  t.refine.mean_irradiance = cursor_.mean_irradiance;
  t.refine.ambient = cursor_.iteration == 0 ? 0.5 * cursor_.mean_irradiance : 0;
  t.refine.reference_area = prepared_->light.reference_area;
  t.refine.min_edge = prepared_->plan.min_edge;
  t.refine.tolerance = prepared_->model.tolerance;
  t.over = cursor_.sweep > 0 ? kOver : 1;
  t.lamp_cap = kLampOfMean * cursor_.mean_radiosity;
  return t;
}

double Scheduler::residual() const {
  const double norm = prepared_->light.exitance_norm;
  return norm > 0 ? std::sqrt(sweep_.sums.change2) / norm : 0;
}

// Of the sweep that ended.
SweepOutcome Scheduler::outcome() const {
  const double reflected = light_with_pending() * luminance(sweep_.sums.reflected);
  SweepOutcome o;
  o.change = reflected > 0 ? sweep_.sums.change / reflected : 0;
  o.residual = residual();
  o.noisy = sweep_.refined.kernels > 0;
  return o;
}

bool Scheduler::limits_reached() {
  if (stop_flag.load()) stop_ = Stop::kRequested;
  // Of this process: a run that is resumed may take as long again.
  if (options_.time_limit > 0 && report_.process_seconds() >= options_.time_limit)
    stop_ = Stop::kTime;
  return stop_ != Stop::kNone;
}

// The requests of the gathers to come, this iteration's and the next one's: R, then the sources
// that it reads.
void Scheduler::foresee_more() {
  std::vector<RecordId> requests;
  const std::size_t n = order_.size();
  while (directory_.store().foreseen() + requests.size() < kForesight && foreseen_ahead_ < n) {
    const ClusterId receiver = order_[(sweep_.gathered + foreseen_ahead_) % n];
    requests.push_back(record_id(RecordKind::kCluster, receiver.value));
    for (const ClusterId s : prepared_->model.visible[receiver.value])
      if (s != receiver) requests.push_back(record_id(RecordKind::kCluster, s.value));
    ++foreseen_ahead_;
  }
  directory_.store().foresee(requests);
}

// What comes next are other requests.
void Scheduler::forget_foreseen() {
  directory_.store().forget_foreseen();
  foreseen_ahead_ = 0;
}

// Links have what all else leaves of the memory, now: the coarse system and the ray worlds grow and
// go while they are made. beside: bytes that are about to be taken.
Status Scheduler::fit_links(std::uint64_t beside) {
  const ClusterStore& store = directory_.store();
  // The receiver's braids, as they are made and as they are kept.
  const std::uint64_t gather =
      2 * std::max(sweep_.working_set_bytes, summary().max_working_set_bytes);
  const std::uint64_t others = prepared_->bytes + ClusterStore::arena_memory(store.arena_bytes()) +
                               store.directory_bytes() + worlds_->bytes() + equilibrium_->bytes() +
                               gather + beside;
  return links_->fit(options_.memory - std::min(options_.memory, others), order_);
}

// By links, or what a local pass does instead.
Result<GatherReport> Scheduler::gather_to(ClusterId receiver) {
  const Model& model = prepared_->model;
  ClusterStore& store = directory_.store();
  if (cursor_.phase == Phase::kLinks)
    return gather_cluster(model, store, *worlds_, task_for(receiver));
  if (cursor_.phase == Phase::kMend) return put_in_mend(store, receiver, *equilibrium_);
  if (!bright_) {
    Result<BrightSources> found = BrightSources::find(model, store);
    if (!found.ok()) return found.status();
    bright_.emplace(std::move(found).value());
  }
  return measure_mend(store, *fresh_, *bright_, receiver, {}, *equilibrium_);
}

// One complete gather to every cluster, or the rest of one.
Status Scheduler::sweep() {
  if (sweep_.gathered == order_.size()) {
    sweep_ = {};
    report_.begin_sweep();
  }
  const bool by_links = cursor_.phase == Phase::kLinks;
  if (!by_links) forget_foreseen();
  while (sweep_.gathered < order_.size()) {
    ATRIUM_RETURN_IF_ERROR(checkpoint_if_due());
    if (limits_reached()) return record_history(cursor_.level, false);
    if (by_links) foresee_more();
    if (sweep_.gathered == 0) directory_.mark_iteration(cursor_.iteration + 1);
    ATRIUM_RETURN_IF_ERROR(fit_links());
    directory_.mark_gather(record_id(RecordKind::kCluster, order_[sweep_.gathered].value));
    const Result<GatherReport> report = gather_to(order_[sweep_.gathered]);
    if (!report.ok()) return report.status();
    if (by_links) --foreseen_ahead_;
    sweep_.add(*report);
    ATRIUM_RETURN_IF_ERROR(report_.show(cursor_, sweep_, false));
    if (report_.line_due()) ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, false));
  }
  give_back_free_memory();
  std::optional<LinksKept> kept;
  if (by_links && cursor_.sweep == 0 && options_.links != "discard") kept = links_->kept();
  // The iteration is over and its consequences drawn before anything can fail again.
  const std::uint32_t level = cursor_.level;
  if (cursor_.phase != Phase::kMend) summary().iterations = ++cursor_.iteration;
  end_sweep();
  if (!by_links) return {};
  follow(after_sweep(cursor_, options_, outcome()));
  if (kept) ATRIUM_RETURN_IF_ERROR(report_.log_links(*kept));
  return cursor_.phase == Phase::kJudge ? Status() : record_history(level, true);
}

void Scheduler::end_sweep() {
  if (cursor_.phase == Phase::kMeasure) {
    equilibrium_->spread_gains();
    bright_.reset();
    cursor_.phase = Phase::kMend;
    return;
  }
  report_.end_sweep(sweep_);
  if (cursor_.phase == Phase::kMend) {
    equilibrium_->forget();
    cursor_.mended = 1;
    cursor_.unseen = 1;
    cursor_.phase = Phase::kJudge;
    return;
  }
  cursor_.residual = residual();
  equilibrium_->correct(cursor_.residual);
  report_.count_links(sweep_, cursor_.residual);
  const PushPullSums& s = sweep_.sums;
  if (s.area > 0) {
    cursor_.mean_irradiance = light_with_pending() * s.flux_in / s.area;
    cursor_.mean_radiosity = luminance(s.emitted + light_with_pending() * s.reflected) / s.area;
  }
}

// Looks at the error, each closer than the last, as far as it takes.
Status Scheduler::look_at_error() {
  for (std::size_t look = 0; look < kLooks.size(); ++look) {
    if (!needs_look(look, cursor_, options_, summary().estimate, summary().links)) continue;
    const Result<ErrorEstimate> found =
        estimate_error(prepared_->model, directory_.store(), *fresh_, kLooks[look]);
    if (!found.ok()) return found.status();
    summary().estimate = *found;
    cursor_.unseen = 0;
  }
  return {};
}

Status Scheduler::record_history(std::uint32_t level, bool complete) {
  HistoryLine line = report_.line(cursor_, sweep_, complete);
  if (!complete) return report_.record(line, level, complete);
  forget_foreseen();  // records of points are read between the gathers'
  if (reference_) {
    Result<double> e = reference_->error(prepared_->model, directory_.store());
    if (!e.ok()) return e.status();
    line.error_true = summary().error_true = *e;
  }
  ATRIUM_RETURN_IF_ERROR(look_at_error());
  line.estimate = summary().estimate;
  return report_.record(line, level, complete);
}

// Nothing will be gathered again across the links of a level that is over, or of a run that has
// ended for good.
void Scheduler::follow(const Next& next) {
  stop_ = next.stop;
  if (next.level_begins || cursor_.done) links_->forget_all();
  if (next.level_begins) equilibrium_->forget();
  if (cursor_.done && directory_.store().contains(kEquilibriumRecord))
    directory_.store().drop_streamed(kEquilibriumRecord);
}

// Is the solution as exact as asked?
Status Scheduler::judge() {
  ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, true));
  for (const ClusterId c : order_) drop_mend(directory_.store(), c);
  follow(after_estimate(cursor_, options_, summary().estimate, summary().links));
  return {};
}

// The loop over receivers "until convergence" [THFH94 §5.1], level by level.
Status Scheduler::iterate() {
  if (cursor_.done) stop_ = static_cast<Stop>(cursor_.done);
  if (options_.iterations && cursor_.iteration >= options_.iterations) stop_ = Stop::kIterations;
  while (stop_ == Stop::kNone)
    ATRIUM_RETURN_IF_ERROR(cursor_.phase == Phase::kJudge ? judge() : sweep());
  return {};
}

// Everything durable; then the summary, which tells of that too, and a last small checkpoint, which
// knows the summary.
Status Scheduler::finish() {
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  directory_.end_trace();
  ATRIUM_RETURN_IF_ERROR(report_.write_summary());
  summary_written_ = true;
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  return report_.show(cursor_, sweep_, true);
}

Status Scheduler::prepare_all() {
  Result<Prepared> prepared = prepare(options_);
  if (!prepared.ok()) return prepared.status();
  prepared_.emplace(std::move(prepared).value());
  give_back_free_memory();
  for (const std::string& w : prepared_->plan.warnings) report_.say("warning: " + w);
  const Model& model = prepared_->model;
  Result<std::vector<ClusterId>> order = make_order(options_.order, model, options_.seed);
  if (!order.ok()) return order.status();
  order_ = std::move(order).value();
  equilibrium_.emplace(model, order_);
  if (!options_.reference.empty()) {
    Result<ReferencePoints> points =
        ReferencePoints::read(options_.reference, prepared_->scene, model);
    if (!points.ok()) return points.status();
    reference_.emplace(std::move(points).value());
  }
  report_.begin(*prepared_);
  cursor_.mean_irradiance = prepared_->light.irradiance;
  cursor_.mean_radiosity = prepared_->light.radiosity;
  sweep_.gathered = order_.size();  // none is under way
  return {};
}

Result<SolveSummary> Scheduler::run() {
  ATRIUM_RETURN_IF_ERROR(validate(options_));
  ATRIUM_RETURN_IF_ERROR(open_run());
  ATRIUM_RETURN_IF_ERROR(prepare_all());
  ATRIUM_RETURN_IF_ERROR(take_up_run());
  const Model& model = prepared_->model;
  const RayUse rays = forces(options_, kRays) ? RayUse::kAlways : RayUse::kWhereSomethingMayBlock;
  constexpr std::uint64_t kShareOfWorlds = 8;
  worlds_ = std::make_unique<RayWorlds>(model, directory_.store(), rays,
                                        options_.memory / kShareOfWorlds);
  fresh_ = std::make_unique<FreshGather>(model, directory_.store(), *worlds_);
  links_ = std::make_unique<KeptLinks>(directory_.store(), model.clusters.size());
  ATRIUM_RETURN_IF_ERROR(report_.show(cursor_, sweep_, true));
  const Status solved = iterate();
  if (!solved.ok()) stop_ = Stop::kFailed;
  summary().stop_reason = reason(stop_);
  summary().exit_code = solved.ok() ? exit_code(stop_) : static_cast<int>(solved.code());
  const Status finished = finish();  // what was done is kept, if the store still can
  if (!solved.ok()) return solved;
  if (!finished.ok()) return finished;
  return summary();
}

}  // namespace

void request_stop() { stop_flag.store(true); }
void request_checkpoint() { checkpoint_flag.store(true); }

Result<SolveSummary> solve(const SolveOptions& options, const ProgressCallback& progress,
                           const LogCallback& log) {
  keep_heap_small();
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return Scheduler(options, progress, log).run();
}

}  // namespace atrium
