#include "scheduler/solve.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>

#include "engine/stopwatch.h"
#include "pagestore/trace.h"
#include "scheduler/first_records.h"
#include "scheduler/gather_cluster.h"
#include "scheduler/levels.h"
#include "scheduler/local_pass.h"
#include "scheduler/memory.h"
#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "scheduler/record_pieces.h"
#include "scheduler/reference_points.h"
#include "scheduler/run_directory.h"
#include "scheduler/run_report.h"
#include "scheduler/warm_start.h"

namespace atrium {

namespace {

std::atomic<bool> stop_flag{false}, checkpoint_flag{false};

// A gather across kept links takes so many times what it changes: what the coarse units do not tell
// falls to .17 or .2 from sweep to sweep, to .3 or .4 without. Light in narrow gaps (behind an
// office's radiators) would do with 1.4, but nothing falls faster than to .2 where it is 1.2.
constexpr double kOver = 1.15;
// Sources brighter than this many times the mean are lamps: they do not stand for their room.
constexpr double kLampOfMean = 8;

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
  Status take_up_run();  // from where an earlier process left it, or
  Status begin_run();
  void take_up_links();
  Status begin_from_another();
  Status save_iteration();
  Status leave_factors();
  Status checkpoint();
  Status checkpoint_state();
  Status checkpoint_if_due();
  Status finish();

  // The iteration.
  Status prepare_all();
  Status iterate();
  Status look_at_rest();
  Status settle_at_rest();
  void gather_to_reached();
  void begin_sweep();
  Status sweep();
  Result<GatherReport> gather_to(ClusterId receiver);
  void end_sweep();
  Status judge();
  void follow(const Next& next);
  bool reach_further();
  bool uses_kept_links(ClusterId receiver) const {
    return options_.links != "discard" && links_->has(receiver);
  }
  GatherTask task_for(ClusterId receiver);
  void foresee_more();
  void forget_foreseen();
  bool limits_reached();
  Status fit_links();
  Status find_bright();
  Status find_pieces();
  double light_with_pending() const;
  double residual() const;
  SweepOutcome outcome(bool reaches_further) const;

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
  std::optional<BrightSources> bright_;  // while rays gather from the solution
  std::optional<LocalSettings> local_;   // while they do so at all pieces
  std::vector<ClusterId> order_;         // of all clusters
  std::vector<ClusterId> reached_;       // those that are gathered to, in that order
  std::optional<GatherReport> at_rest_;  // sums over the others
  std::unique_ptr<KeptLinks> links_;
  std::optional<Equilibrium> equilibrium_;
  Cursor cursor_;
  Sweep sweep_;
  std::uint64_t foreseen_ahead_ = 0;  // gathers after the one that comes next
  Stop stop_ = Stop::kNone;
  bool summary_written_ = false;  // of this end
  std::uint64_t largest_braids_ = 0;  // bytes, of one receiver's gather in this process
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
  if (!earlier.begun) return begin_run();
  if (earlier.model_hash != model_hash_)
    return Status(
        Code::kUsage, options_.scene.files.front(), "",
        "the scene is not the one that the run in " + options_.run_directory + " was begun with",
        "give back the scene as it was, or solve into another directory");
  cursor_ = earlier.cursor;
  sweep_ = earlier.sweep;
  report_.gathers_to(sweep_.gathered);
  if (!cursor_.done) {
    if (!cursor_.divided) equilibrium_.emplace(prepared_->model, order_, Division::kNone);
    ATRIUM_RETURN_IF_ERROR(equilibrium_->restore(directory_.store()));
    gather_to_reached();
  }
  report_.take_up(earlier);
  return {};
}

Status Scheduler::begin_run() {
  ATRIUM_RETURN_IF_ERROR(directory_.see_to_disk(prepared_->plan));
  if (options_.from.empty())
    ATRIUM_RETURN_IF_ERROR(write_first_records(*prepared_, options_.basis, directory_.store()));
  else
    ATRIUM_RETURN_IF_ERROR(begin_from_another());
  gather_to_reached();
  sweep_.gathered = reached_.size();  // none is under way
  ATRIUM_RETURN_IF_ERROR(report_.log_gaps(prepared_->plan.closed_gaps));
  return checkpoint();
}

// A level's links are made receiver by receiver in its first sweep: of those that it has not come
// to they are the last level's.
void Scheduler::take_up_links() {
  links_ = std::make_unique<KeptLinks>(directory_.store(), order_.size());
  if (cursor_.sweep > 0) return;
  const bool under_way = sweep_.gathered < reached_.size();
  for (std::size_t i = under_way ? sweep_.gathered : 0; i < reached_.size(); ++i)
    links_->become_past(reached_[i]);
}

Status Scheduler::begin_from_another() {
  const Result<std::unique_ptr<WarmStart>> opened = WarmStart::open(options_, *prepared_);
  if (!opened.ok()) return opened.status();
  WarmStart& warm = **opened;
  TreesOf trees_of;
  if (warm.takes_over()) trees_of = [&](ClusterId c) { return warm.trees_of(c); };
  ATRIUM_RETURN_IF_ERROR(
      write_first_records(*prepared_, options_.basis, directory_.store(), trees_of));
  if (warm.takes_over()) equilibrium_.emplace(prepared_->model, order_, Division::kNone);
  ATRIUM_RETURN_IF_ERROR(warm.begin(*equilibrium_, cursor_));
  cursor_.divided = !warm.takes_over();
  summary().warm = warm.figures(*equilibrium_);
  if (cursor_.phase == Phase::kJudge) {  // nothing will be gathered
    summary().estimate = warm.estimate();
    ATRIUM_RETURN_IF_ERROR(look_at_rest());
    Sweep all;
    all.add(*at_rest_, order_.size());
    report_.end_sweep(all);
  }
  return report_.log("start from " + options_.from + ": " +
                     in_words(summary().warm, prepared_->plan));
}

Status Scheduler::save_iteration() {
  if (links_) ATRIUM_RETURN_IF_ERROR(links_->save());
  return equilibrium_->save(directory_.store());
}

// Of a run that has ended the coarse system's form factors stay, for who starts from it.
Status Scheduler::leave_factors() {
  ClusterStore& store = directory_.store();
  if (!has_pieces(store, RecordKind::kEquilibrium)) return {};  // it had ended before
  ATRIUM_RETURN_IF_ERROR(equilibrium_->leave_factors(store));
  drop_pieces(store, RecordKind::kEquilibrium);
  return {};
}

// Between two gathers: all of the solve that is not a function of the scene and the options.
Status Scheduler::checkpoint() {
  ATRIUM_RETURN_IF_ERROR(cursor_.done ? leave_factors() : save_iteration());
  return checkpoint_state();
}

// Where nothing else has changed since the last checkpoint.
Status Scheduler::checkpoint_state() {
  RunState state;
  state.begun = 1;
  state.model_hash = model_hash_;
  state.error_asked = options_.error;
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
  const bool discard = options_.links == "discard", kept = uses_kept_links(receiver);
  const bool linked = discard ? cursor_.sweep > 0 : kept;
  if (!discard) t.linking = kept ? Linking::kUseKept : Linking::kMakeAndKeep;
  t.refine.threshold = link_threshold(cursor_, options_);
  t.refine.mean_irradiance = cursor_.mean_irradiance;
  const bool dark = cursor_.level == 0 && cursor_.iteration == 0 && reached_.size() == order_.size();
  t.refine.ambient = dark ? 0.5 * cursor_.mean_irradiance : 0;
  t.refine.reference_area = prepared_->light.reference_area;
  t.refine.min_edge = prepared_->plan.min_edge;
  t.refine.tolerance = prepared_->model.tolerance;
  t.over = linked ? kOver : 1;
  t.lamp_cap = kLampOfMean * cursor_.mean_radiosity;
  return t;
}

double Scheduler::residual() const {
  const double norm = prepared_->light.exitance_norm;
  return norm > 0 ? std::sqrt(sweep_.sums.change2) / norm : 0;
}

// Of the sweep that ended. What will change in clusters that it has yet to reach is not known.
SweepOutcome Scheduler::outcome(bool reaches_further) const {
  const double reflected = light_with_pending() * luminance(sweep_.sums.reflected);
  SweepOutcome o;
  o.change = reaches_further ? 1 : reflected > 0 ? sweep_.sums.change / reflected : 0;
  const double arriving = light_with_pending() * sweep_.sums.flux_in;
  o.awaited = arriving > 0 ? equilibrium_->flux_awaited() / arriving : 0;
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
  const std::size_t n = reached_.size();
  while (directory_.store().foreseen() + requests.size() < kForesight && foreseen_ahead_ < n) {
    const ClusterId receiver = reached_[(sweep_.gathered + foreseen_ahead_) % n];
    requests.push_back(record_id(RecordKind::kCluster, receiver.value));
    const std::span<const ClusterId> sources = prepared_->model.visible[receiver.value];
    const bool linked = uses_kept_links(receiver);
    for (std::size_t i = 0; i < sources.size(); ++i)
      if (sources[i] != receiver && (!linked || links_->carries_light(receiver, i)))
        requests.push_back(record_id(RecordKind::kCluster, sources[i].value));
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
// go while they are made.
Status Scheduler::fit_links() {
  const ClusterStore& store = directory_.store();
  // As they are made, as they are kept, and those of the level before.
  const std::uint64_t gather = 3 * largest_braids_;
  const std::uint64_t others = prepared_->bytes +
                               ClusterStore::arena_memory(store.arena_bytes()) +
                               store.directory_bytes() + worlds_->bytes() +
                               equilibrium_->bytes() + (bright_ ? bright_->bytes() : 0) + gather;
  return links_->fit(options_.memory - std::min(options_.memory, others), order_);
}

Status Scheduler::find_bright() {
  if (bright_) return {};
  Result<BrightSources> found = BrightSources::find(prepared_->model, directory_.store());
  if (!found.ok()) return found.status();
  bright_.emplace(std::move(found).value());
  ATRIUM_RETURN_IF_ERROR(fit_links());
  give_back_free_memory();  // of links that are gone: rays take large blocks, not their pieces
  return {};
}

Status Scheduler::find_pieces() {
  if (local_) return {};
  const Result<double> mean = mean_leaf_area(prepared_->model, directory_.store());
  if (!mean.ok()) return mean.status();
  local_.emplace(LocalSettings{.piece = kPieceOfLeaf * *mean});
  return {};
}

// By links, or what a local pass does instead.
Result<GatherReport> Scheduler::gather_to(ClusterId receiver) {
  const Model& model = prepared_->model;
  ClusterStore& store = directory_.store();
  if (cursor_.phase == Phase::kLinks)
    return gather_cluster(model, store, *worlds_, task_for(receiver));
  if (cursor_.phase == Phase::kMend) return put_in_mend(store, receiver, *equilibrium_);
  ATRIUM_RETURN_IF_ERROR(find_bright());
  ATRIUM_RETURN_IF_ERROR(find_pieces());
  return measure_mend(store, *fresh_, *bright_, receiver, *local_, *equilibrium_);
}

// The sums over all that the sweep leaves as it is.
Status Scheduler::look_at_rest() {
  GatherReport all;
  for (const ClusterId c : order_) {
    if (equilibrium_->reached(c) != Reached::kNot) continue;
    const Result<GatherReport> report = at_rest(directory_.store(), c);
    if (!report.ok()) return report.status();
    all.sums.add(report->sums);
    all.elements += report->elements;
  }
  at_rest_ = all;
  return {};
}

// What the coarse system adds to clusters at rest is part of their light when that is measured.
Status Scheduler::settle_at_rest() {
  if (reached_.size() == order_.size()) return {};
  forget_foreseen();
  at_rest_.reset();
  return put_in_pending(directory_.store(), prepared_->model, *equilibrium_);
}

void Scheduler::gather_to_reached() {
  std::vector<ClusterId> reached;
  for (const ClusterId c : order_)
    if (equilibrium_->reached(c) == Reached::kNow) reached.push_back(c);
  if (reached != reached_) forget_foreseen();
  reached_ = std::move(reached);
  report_.gathers_to(reached_.size());
}

void Scheduler::begin_sweep() {
  equilibrium_->begin_sweep();
  gather_to_reached();
  summary().warm.clusters_reached = reached_.size();
  sweep_ = {};
  report_.begin_sweep();
}

// One complete gather to every cluster that is reached, or the rest of one.
Status Scheduler::sweep() {
  const bool by_links = cursor_.phase == Phase::kLinks;
  if (cursor_.phase == Phase::kMeasure && sweep_.gathered == reached_.size())
    ATRIUM_RETURN_IF_ERROR(settle_at_rest());
  if (!at_rest_) ATRIUM_RETURN_IF_ERROR(look_at_rest());
  if (sweep_.gathered == reached_.size()) begin_sweep();
  if (!by_links) forget_foreseen();
  while (sweep_.gathered < reached_.size()) {
    ATRIUM_RETURN_IF_ERROR(checkpoint_if_due());
    if (limits_reached()) return record_history(cursor_.level, false);
    if (by_links) foresee_more();
    if (sweep_.gathered == 0) directory_.mark_iteration(cursor_.iteration + 1);
    ATRIUM_RETURN_IF_ERROR(fit_links());
    const ClusterId receiver = reached_[sweep_.gathered];
    directory_.mark_gather(record_id(RecordKind::kCluster, receiver.value));
    const Result<GatherReport> report = gather_to(receiver);
    if (!report.ok()) return report.status();
    if (by_links) --foreseen_ahead_;
    largest_braids_ = std::max(largest_braids_, report->link_bytes);
    sweep_.add(*report, reached_.size());
    ATRIUM_RETURN_IF_ERROR(report_.show(cursor_, sweep_, false));
    if (report_.line_due()) ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, false));
  }
  directory_.mark_iteration(kBetweenIterations);
  give_back_free_memory();
  std::optional<LinksKept> kept;
  if (by_links && cursor_.sweep == 0 && options_.links != "discard") kept = links_->kept();
  // The iteration is over and its consequences drawn before anything can fail again.
  const std::uint32_t level = cursor_.level;
  if (cursor_.phase != Phase::kMend) summary().iterations = ++cursor_.iteration;
  end_sweep();
  if (!by_links) return {};
  follow(after_sweep(cursor_, options_, outcome(reach_further())));
  if (cursor_.phase == Phase::kJudge && cursor_.to_mend) {
    cursor_.phase = Phase::kMeasure;
    cursor_.to_mend = 0;
  }
  if (kept) ATRIUM_RETURN_IF_ERROR(report_.log_links(*kept));
  return cursor_.phase == Phase::kJudge ? Status() : record_history(level, true);
}

void Scheduler::end_sweep() {
  if (cursor_.phase == Phase::kMeasure) {
    equilibrium_->spread_gains();
    bright_.reset();
    local_.reset();
    cursor_.phase = Phase::kMend;
    return;
  }
  sweep_.sums.add(at_rest_->sums);
  sweep_.elements += at_rest_->elements;
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

// Does what has changed go further than was thought? Those clusters join the next sweep.
bool Scheduler::reach_further() {
  const bool further = atrium::reach_further(options_, prepared_->model, cursor_.mean_irradiance,
                                             *equilibrium_) > 0;
  if (further) at_rest_.reset();
  return further;
}

// Looks at the error, each closer than the last, as far as it takes. Where few clusters are
// gathered to it is only judged: a look would cost more than a sweep.
Status Scheduler::look_at_error() {
  if (reached_.size() < order_.size() && cursor_.phase != Phase::kJudge) return {};
  for (std::size_t look = 0; look < kLooks.size(); ++look) {
    if (!needs_look(look, cursor_, options_, summary().estimate, summary().links)) continue;
    const std::clock_t start = std::clock();
    ATRIUM_RETURN_IF_ERROR(find_bright());
    const double finding = double(std::clock() - start) / CLOCKS_PER_SEC;
    EstimateSettings settings = kLooks[look];
    settings.asked = options_.error;
    const Result<ErrorEstimate> found =
        estimate_error(prepared_->model, directory_.store(), *fresh_, *bright_, settings);
    if (!found.ok()) return found.status();
    summary().estimate = *found;
    summary().estimate.cpu_seconds += finding;
    cursor_.unseen = 0;
  }
  bright_.reset();
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

// Nothing will be gathered again across the links of a level that is over, and nothing at all in a
// run that has ended for good.
void Scheduler::follow(const Next& next) {
  stop_ = next.stop;
  if (cursor_.done) links_->forget_all();
  if (!next.level_begins) return;
  for (const ClusterId c : order_) links_->become_past(c);
  equilibrium_->forget();
  for (const ClusterId c : order_) equilibrium_->reach(c);
  at_rest_.reset();
  cursor_.to_mend = 0;
}

// Is the solution as exact as asked?
Status Scheduler::judge() {
  ATRIUM_RETURN_IF_ERROR(settle_at_rest());
  ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, true));
  for (const ClusterId c : order_) drop_mend(directory_.store(), c);
  follow(after_estimate(cursor_, options_, summary().estimate, summary().links));
  if (cursor_.phase == Phase::kMeasure)  // all of it is to become more exact
    for (const ClusterId c : order_) equilibrium_->reach(c);
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
  fresh_.reset();  // what a checkpoint takes comes in their place
  worlds_.reset();
  give_back_free_memory();
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  directory_.end_trace();
  ATRIUM_RETURN_IF_ERROR(report_.write_summary());
  summary_written_ = true;
  ATRIUM_RETURN_IF_ERROR(checkpoint_state());
  return report_.show(cursor_, sweep_, true);
}

Status Scheduler::prepare_all() {
  Result<Prepared> prepared = prepare(options_);
  if (!prepared.ok()) return prepared.status();
  prepared_.emplace(std::move(prepared).value());
  give_back_free_memory();
  for (const std::string& w : prepared_->plan.warnings) report_.say("warning: " + w);
  const Model& model = prepared_->model;
  const double start = now();
  Result<std::vector<ClusterId>> order =
      make_order(options_.order, {model, prepared_->scene.materials, options_.seed});
  if (!order.ok()) return order.status();
  order_ = std::move(order).value();
  ATRIUM_RETURN_IF_ERROR(report_.log("order " + options_.order + " was made in " +
                                     std::to_string(now() - start) + " s"));
  equilibrium_.emplace(model, order_, Division::kWhereItPays);
  if (!options_.reference.empty()) {
    Result<ReferencePoints> points =
        ReferencePoints::read(options_.reference, prepared_->scene, model);
    if (!points.ok()) return points.status();
    reference_.emplace(std::move(points).value());
  }
  report_.begin(*prepared_);
  summary().from = options_.from;
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
  worlds_ = std::make_unique<RayWorlds>(model, rays, options_.memory / kShareOfWorlds);
  fresh_ = std::make_unique<FreshGather>(model, directory_.store(), *worlds_);
  take_up_links();
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
