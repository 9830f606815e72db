#include "scheduler/solve.h"

#include <sys/resource.h>
#include <unistd.h>
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <optional>

#include "engine/squared.h"
#include "engine/stopwatch.h"
#include "scheduler/first_records.h"
#include "scheduler/gather_cluster.h"
#include "scheduler/history.h"
#include "scheduler/local_pass.h"
#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "scheduler/reference_points.h"
#include "scheduler/run_directory.h"

namespace atrium {

namespace {

std::atomic<bool> stop_flag{false}, checkpoint_flag{false};

// Refinement goes from coarse to fine: each level's link threshold is this many times the last's,
// so that brightness is known roughly before it decides what is worth refining.
constexpr std::array<double, 3> kLevels{16, 4, 1};
// The first level alone knows brightness too little for its estimate to be the last word: its rows may be
// so far off that they had to be scaled.
constexpr std::uint32_t kFirstTaken = 1;
// Link threshold of the last level ÷ error asked for: found on the scenes with references, so that
// what is asked for is about what the truth says.
constexpr double kThresholdOfError = 0.005;
// A level ends when the light still to come is below this share of all: coarse ones, and for the
// last relative to the error asked for.
constexpr double kCoarseRest = 0.01;
constexpr double kFineRestOfError = 1.0 / 50;
// An answer that is taken has settled beyond that: sweeps over kept links cost next to nothing.
constexpr double kTakenRest = 1e-6;
constexpr std::uint32_t kMostSettling = 12;
// So many sweeps in a row without progress, and none is to be expected. Links that are made anew
// each time are not quite the same each time: where there are such, the change stays at their
// noise, and progress is a change that falls by a tenth.
constexpr std::uint32_t kStalledSweeps = 30, kNoisySweeps = 6;
constexpr double kNoisyProgress = 0.9;
// Where the estimate is above the error asked, links are made finer: by the square of how much, in
// these bounds, beyond the last level so often at most.
constexpr double kTightest = 1.0 / 8, kLoosest = 1.0 / 2;
constexpr std::uint32_t kMostTightened = 1;
// A local pass about halves the error of the last level: where its links are not as fine as they
// may be, it is made if that will surely do. Coarse ones gain too little from it.
constexpr double kMendedByPass = 1.5;
// A gather across kept links takes so many times what it changes: what the coarse units do not tell
// falls to .2 (a cube) or .5 (Cornell) from sweep to sweep without, to .2 or .35 with it. Above 1.3
// the cube takes more sweeps than it saves elsewhere.
constexpr double kOver = 1.25;
// Sources brighter than this many times the mean are lamps: they do not stand for their room.
constexpr double kLampOfMean = 8;

double cpu_now() { return double(std::clock()) / CLOCKS_PER_SEC; }

std::uint64_t peak_rss() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return std::uint64_t(u.ru_maxrss) * 1024;
}

constexpr RecordId kEquilibriumRecord = record_id(RecordKind::kEquilibrium, 0);

// Requests whose records are foreseen at a time; what is needed next is among them.
constexpr std::uint64_t kForesight = 1 << 16;
constexpr double kStatusInterval = 0.2;    // s between renewals of the status page and progress
constexpr double kHistoryInterval = 60;    // s between lines of an iteration that goes on

// What sweeps have changed since the last estimate, as a share of the light, against the error that
// it found: below this it still holds, for a line of the history and to be judged by.
constexpr double kStale = 0.3, kStaleToJudge = 0.1;
// The error is looked at closer where the interval is vague, its ends so many times apart; and, to
// be judged, ever closer while what was asked lies within. The first look is for few links, which
// cost less than the second one.
constexpr double kVague = 2.5;
constexpr std::array<EstimateSettings, 3> kLooks{
    {{.points = 256, .directions = 128, .seed = 4},
     {.points = 768, .directions = 128, .seed = 2},
     {.points = 2048, .directions = 256, .seed = 3}}};
constexpr std::uint64_t kFewLinks = 1 << 16;

enum class Stop { kNone, kConverged, kResidual, kIterations, kTime, kRequested, kStalled, kTooCoarse, kFailed };

const char* reason(Stop s) {
  switch (s) {
    case Stop::kConverged: return "converged";
    case Stop::kResidual: return "residual reached";
    case Stop::kIterations: return "iteration limit";
    case Stop::kTime: return "time limit";
    case Stop::kRequested: return "stopped on request";
    case Stop::kStalled: return "no longer converging";
    case Stop::kTooCoarse: return "estimated error above what was asked";
    case Stop::kFailed: return "failed";
    case Stop::kNone: break;
  }
  return "";
}

int exit_code(Stop s) {
  if (s == Stop::kRequested) return static_cast<int>(Code::kStopped);
  if (s == Stop::kIterations || s == Stop::kTime || s == Stop::kStalled ||
      s == Stop::kTooCoarse) return static_cast<int>(Code::kLimit);
  return 0;
}

// The radiosity scheduler: "the conceptual center of the system". [THFH94 §4]
class Scheduler {
 public:
  Scheduler(const SolveOptions& options, const ProgressCallback& progress, const LogCallback& log)
      : options_(options),
        progress_(progress),
        log_(log),
        start_(now()),
        cpu_start_(cpu_now()),
        directory_(options, log) {}

  Result<SolveSummary> run();

 private:
  // The run on disk.
  Status open_run();
  Status take_up_run();
  Status log_gaps();
  Status checkpoint();
  Status checkpoint_if_due();

  // The iteration.
  Status prepare_all();
  Status iterate();
  Status sweep();
  Result<GatherReport> gather_to(ClusterId receiver);
  Status judge();
  Status look_at_error();
  void begin_level(double threshold);
  void end_for_good();
  GatherTask task_for(ClusterId receiver);
  void foresee_more();
  void forget_foreseen();
  void end_sweep();
  void conclude();
  bool at_last_level() const { return cursor_.level + 1 == kLevels.size(); }
  bool limits_reached();
  double light_with_pending() const;
  double rest_of_light(double change) const;
  double residual() const;
  bool stalled(double change);

  // What is told of it.
  Status record_history(std::uint32_t level, bool complete);
  Status show(bool now_at_once);
  void fill_summary();
  Status finish();
  StoreCounters counters() const {
    return directory_.earlier().counters + directory_.store().counters();
  }
  double seconds() const { return directory_.earlier().seconds + now() - start_; }
  double cpu_seconds() const { return directory_.earlier().cpu_seconds + cpu_now() - cpu_start_; }
  void say(const std::string& text) {
    if (log_) log_(text);
  }

  const SolveOptions& options_;
  const ProgressCallback& progress_;
  const LogCallback& log_;
  const double start_, cpu_start_;
  RunDirectory directory_;
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
  StoreCounters sweep_began_;
  std::uint64_t foreseen_ahead_ = 0;  // gathers after the one that comes next
  Stop stop_ = Stop::kNone;
  bool summary_written_ = false;  // of this end
  SolveSummary summary_;
  HistoryLine last_line_;
  double last_shown_ = 0, last_line_at_ = now();
  double last_checkpoint_ = now(), checkpoint_at_ = -1;
};

// The run directory is there before anything else.
Status Scheduler::open_run() {
  for (const std::string& f : options_.scene.files)
    if (!std::filesystem::exists(f))
      return Status(Code::kScene, f, "", "no such file", "check the path of the scene");
  ATRIUM_RETURN_IF_ERROR(directory_.open());
  return show(true);
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
    ATRIUM_RETURN_IF_ERROR(log_gaps());
    return checkpoint();
  }
  if (earlier.model_hash != model_hash_)
    return Status(Code::kUsage, options_.scene.files.front(), "",
                  "the scene is not the one that the run in " + options_.run_directory +
                      " was begun with",
                  "give back the scene as it was, or solve into another directory");
  cursor_ = earlier.cursor;
  sweep_ = earlier.sweep;
  sweep_began_ = earlier.sweep_began;
  static_cast<SolveFigures&>(summary_) = earlier.figures;
  ++summary_.resumes;
  if (directory_.store().contains(kEquilibriumRecord)) {
    const auto record = directory_.store().stream_in(kEquilibriumRecord);
    if (!record.ok()) return record.status();
    ATRIUM_RETURN_IF_ERROR(equilibrium_->restore(*record));
  }
  say("resumed after " + std::to_string(sweep_.gathered) + " clusters of iteration " +
      std::to_string(cursor_.iteration + (sweep_.gathered < order_.size() ? 1 : 0)));
  return {};
}

// Once a run, by name: what its light does not pass though the scene leaves it open.
Status Scheduler::log_gaps() {
  std::string lines;
  for (const NamedGap& gap : prepared_->plan.closed_gaps) {
    const std::string line = "closed gap: " + gap_words(gap);
    say(line);
    lines += (lines.empty() ? "" : "\n") + line;
  }
  return lines.empty() ? Status() : directory_.files().append_line(RunFile::kLog, lines);
}

// Between two gathers: all of the solve that is not a function of the scene and the options.
Status Scheduler::checkpoint() {
  if (links_ && !cursor_.done) {
    ATRIUM_RETURN_IF_ERROR(links_->save());
    ATRIUM_RETURN_IF_ERROR(
        directory_.store().stream_out(kEquilibriumRecord, equilibrium_->saved()));
  }
  ++summary_.checkpoints;
  RunState state;
  state.begun = 1;
  state.model_hash = model_hash_;
  state.cursor = cursor_;
  state.sweep = sweep_;
  state.figures = summary_;
  state.counters = counters();
  state.sweep_began = sweep_began_;
  state.seconds = seconds();
  state.cpu_seconds = cpu_seconds();
  ATRIUM_RETURN_IF_ERROR(
      directory_.checkpoint(state, stop_ == Stop::kNone || summary_written_));
  last_checkpoint_ = now();
  checkpoint_at_ = seconds();
  return {};
}

Status Scheduler::checkpoint_if_due() {
  const bool asked = checkpoint_flag.exchange(false);
  if (!asked && now() - last_checkpoint_ < options_.checkpoint_every) return {};
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  const std::string text = "checkpoint of epoch " + std::to_string(directory_.store().epoch()) + ": " +
                           std::to_string(directory_.store().live_bytes()) + " bytes live, " +
                           std::to_string(directory_.store().allocated_bytes()) + " allocated";
  say(text);
  return directory_.files().append_line(RunFile::kLog, text);
}

// All irradiance, what the coarse system has found to be still to come with it, as a multiple of what
// is stored.
double Scheduler::light_with_pending() const {
  const double stored = sweep_.sums.flux_in;
  return stored > 0 ? 1 + std::max(0.0, equilibrium_->flux_pending()) / stored : 1;
}

// Light still to come if each sweep adds q times what the last one did, as a share of all; before q
// is known, that it is no more than what the sweep has changed.
double Scheduler::rest_of_light(double change) const {
  if (cursor_.sweep == 0 || !(cursor_.last_change > 0)) return change;
  constexpr double kSlowest = 0.9999;
  const double q = std::clamp(change / cursor_.last_change, 0.0, kSlowest);
  return change * std::max(1.0, q / (1 - q));
}

GatherTask Scheduler::task_for(ClusterId receiver) {
  GatherTask t;
  t.receiver = receiver;
  t.links = links_.get();
  t.equilibrium = &*equilibrium_;
  if (options_.links != "discard")
    t.linking = cursor_.sweep > 0 ? Linking::kUseKept : Linking::kMakeAndKeep;
  t.refine.threshold =
      kThresholdOfError * options_.error * kLevels[cursor_.level] * cursor_.threshold;
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

bool Scheduler::limits_reached() {
  if (stop_flag.load()) stop_ = Stop::kRequested;
  // Of this process: a run that is resumed may take as long again.
  if (options_.time_limit > 0 && now() - start_ >= options_.time_limit) stop_ = Stop::kTime;
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
    sweep_began_ = counters();
  }
  const bool by_links = cursor_.phase == Phase::kLinks;
  if (!by_links) forget_foreseen();
  while (sweep_.gathered < order_.size()) {
    ATRIUM_RETURN_IF_ERROR(checkpoint_if_due());
    if (limits_reached()) return record_history(cursor_.level, false);
    if (by_links) foresee_more();
    if (sweep_.gathered == 0) directory_.mark_iteration(cursor_.iteration + 1);
    directory_.mark_gather(record_id(RecordKind::kCluster, order_[sweep_.gathered].value));
    const Result<GatherReport> report = gather_to(order_[sweep_.gathered]);
    if (!report.ok()) return report.status();
    if (by_links) --foreseen_ahead_;
    sweep_.add(*report);
    ATRIUM_RETURN_IF_ERROR(show(false));
    if (now() - last_line_at_ > kHistoryInterval) ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, false));
  }
  // The iteration is over and its consequences drawn before anything can fail again.
  const std::uint32_t level = cursor_.level;
  if (cursor_.phase != Phase::kMend) summary_.iterations = ++cursor_.iteration;
  end_sweep();
  if (!by_links) return {};
  conclude();
  return cursor_.phase == Phase::kJudge ? Status() : record_history(level, true);
}

// The status page, and the progress line.
Status Scheduler::show(bool at_once) {
  if (!at_once && now() - last_shown_ < kStatusInterval) return {};
  last_shown_ = now();
  RunStatus status;
  status.process = ::getpid();
  status.phase = stop_ != Stop::kNone ? RunPhase::kEnded
                 : order_.empty()     ? RunPhase::kPreparing
                                      : RunPhase::kSolving;
  if (stop_ != Stop::kNone) status.exit_code = summary_.exit_code;
  status.iteration = cursor_.iteration + (sweep_.gathered < order_.size() ? 1 : 0);
  status.gathered = sweep_.gathered;
  status.clusters = order_.size();
  status.elements = sweep_.elements;
  status.links = sweep_.links;
  status.seconds = seconds();
  if (last_line_.iteration > 0) status.residual = last_line_.residual;
  status.hit_ratio = (counters() - sweep_began_).hit_ratio();
  status.checkpoints = summary_.checkpoints;
  status.checkpoint_at = checkpoint_at_;
  status.peak_rss_bytes = peak_rss();
  ATRIUM_RETURN_IF_ERROR(directory_.write_status(status));
  if (!progress_ || stop_ != Stop::kNone) return {};
  Progress p{status.iteration, sweep_.gathered, order_.size(), sweep_.elements,
             sweep_.links,     seconds(),       last_line_.residual, -1};
  const double solving = sweep_.solver_seconds;
  if (sweep_.gathered > 0)
    p.eta_seconds = solving / sweep_.gathered * (order_.size() - sweep_.gathered);
  progress_(p);
  return {};
}

void Scheduler::end_sweep() {
  const PushPullSums& s = sweep_.sums;
  if (cursor_.phase == Phase::kMeasure) {
    equilibrium_->spread_gains();
    bright_.reset();
    cursor_.phase = Phase::kMend;
    return;
  }
  summary_.elements = sweep_.elements;
  summary_.flux_emitted = luminance(s.emitted);
  summary_.flux_absorbed = luminance(s.absorbed);
  summary_.flux_escaped = luminance(s.escaped);
  if (cursor_.phase == Phase::kMend) {
    equilibrium_->forget();
    cursor_.mended = 1;
    cursor_.unseen = 1;
    cursor_.phase = Phase::kJudge;
    return;
  }
  equilibrium_->correct(residual());
  cursor_.residual = summary_.residual = residual();
  if (s.area > 0) {
    cursor_.mean_irradiance = light_with_pending() * s.flux_in / s.area;
    cursor_.mean_radiosity =
        luminance(s.emitted + light_with_pending() * s.reflected) / s.area;
  }
  summary_.links = sweep_.links;
  summary_.max_working_set_bytes = std::max(summary_.max_working_set_bytes, sweep_.working_set_bytes);
  summary_.max_working_set_links = std::max(summary_.max_working_set_links, sweep_.working_set_links);
  summary_.max_working_set_elements =
      std::max(summary_.max_working_set_elements, sweep_.working_set_elements);
  summary_.links_processed += sweep_.links;
  summary_.refined.add(sweep_.refined);
  summary_.total_data_bytes += sweep_.total_bytes;
  summary_.hit_ratio = (counters() - sweep_began_).hit_ratio();
}

// Where what is known of the error is stale; where it is to be judged, until it is clear.
Status Scheduler::look_at_error() {
  const bool judged = cursor_.phase == Phase::kJudge, few = summary_.links < kFewLinks;
  for (std::size_t i = few && !(judged && at_last_level()) ? 0 : 1; i < kLooks.size(); ++i) {
    const ErrorEstimate& known = summary_.estimate;
    const bool stale = known.points == 0 ||
                       cursor_.unseen >= (judged ? kStaleToJudge : kStale) * known.error;
    const bool closer = known.points < static_cast<std::uint64_t>(kLooks[i].points);
    const bool open = judged && (at_last_level() || !few) && known.low <= options_.error &&
                      options_.error < known.high && closer;
    const bool vague = known.high > kVague * known.low && closer && i + 1 < kLooks.size();
    if (!stale && !open && !vague) continue;
    const Result<ErrorEstimate> found =
        estimate_error(prepared_->model, directory_.store(), *fresh_, kLooks[i]);
    if (!found.ok()) return found.status();
    summary_.estimate = *found;
    cursor_.unseen = 0;
  }
  return {};
}

Status Scheduler::record_history(std::uint32_t level, bool complete) {
  const StoreCounters c = counters() - sweep_began_;
  HistoryLine h;
  h.seconds = seconds();
  h.cpu_seconds = cpu_seconds();
  h.iteration = cursor_.iteration + (complete ? 0 : 1);
  h.clusters_gathered = sweep_.gathered;
  h.residual = cursor_.residual;
  h.elements = complete ? summary_.elements : sweep_.elements;
  h.links = complete ? summary_.links : sweep_.links;
  h.rays = sweep_.refined.rays;
  h.reads = c.reads;
  h.writes = c.writes;
  h.bytes_read = c.bytes_read;
  h.bytes_written = c.bytes_written;
  h.hit_ratio = c.hit_ratio();
  h.solver_seconds = sweep_.solver_seconds;
  h.io_seconds = c.io_seconds;
  h.stall_seconds = c.stall_seconds;
  h.max_working_set_bytes = sweep_.working_set_bytes;
  h.peak_rss_bytes = peak_rss();
  if (complete) forget_foreseen();  // records of points are read between the gathers'
  if (complete && reference_) {
    Result<double> e = reference_->error(prepared_->model, directory_.store());
    if (!e.ok()) return e.status();
    h.error_true = summary_.error_true = *e;
  }
  if (complete) {
    ATRIUM_RETURN_IF_ERROR(look_at_error());
    h.estimate = summary_.estimate;
  }
  last_line_ = h;
  last_line_at_ = now();
  if (complete) summary_.solver_seconds += sweep_.solver_seconds;
  char text[256];
  std::snprintf(text, sizeof text,
                "iteration %llu level %u: residual %.3g, %llu elements, %llu links, %llu rays, "
                "hit ratio %.3f, error %.2f%%, %.1f s",
                static_cast<unsigned long long>(h.iteration), level, h.residual,
                static_cast<unsigned long long>(h.elements),
                static_cast<unsigned long long>(h.links), static_cast<unsigned long long>(h.rays),
                h.hit_ratio, 100 * h.estimate.error, h.seconds);
  say(text);
  ATRIUM_RETURN_IF_ERROR(directory_.files().append_line(RunFile::kLog, text));
  return directory_.files().append_line(RunFile::kHistory, history_json(h));
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

// What a complete sweep means: the next level, or an end.
void Scheduler::conclude() {
  const std::uint64_t limit = options_.iterations;
  // Where iterations are counted out, each level gets its share of them.
  const std::uint64_t share = limit ? std::max<std::uint64_t>(1, limit / kLevels.size()) : 0;
  const bool last = at_last_level();
  const PushPullSums& s = sweep_.sums;
  const double reflected = light_with_pending() * luminance(s.reflected);
  const double change = reflected > 0 ? s.change / reflected : 0;
  const double rest = rest_of_light(change);
  ++cursor_.sweep;
  cursor_.last_change = change;
  // What the coarse system adds after a level's first sweep is seen after its second.
  cursor_.unseen = cursor_.sweep <= 2 ? 1 : cursor_.unseen + change;
  const bool no_progress = stalled(change);
  cursor_.rest = rest;
  if (cursor_.settling) ++cursor_.settling;
  const bool settled = rest < (cursor_.settling ? kTakenRest
                               : last           ? kFineRestOfError * options_.error
                                                : kCoarseRest);
  if (last && options_.residual > 0 && residual() <= options_.residual)
    stop_ = Stop::kResidual;
  else if (limit && cursor_.iteration >= limit)
    stop_ = Stop::kIterations;
  else if (options_.residual == 0 &&
           (cursor_.settling > kMostSettling ||
            (last || cursor_.settling ? settled || no_progress : settled && !limit)))
    cursor_.phase = Phase::kJudge;
  else if (last && no_progress)
    stop_ = Stop::kStalled;
  else if (!last && (settled || (share && cursor_.sweep >= share)))
    begin_level(1);
  end_for_good();
}

// The next level, or the last one over again; its link threshold is so many times what it would be.
void Scheduler::begin_level(double threshold) {
  if (cursor_.level + 1 < kLevels.size()) ++cursor_.level;
  cursor_.threshold *= threshold;
  cursor_.phase = Phase::kLinks;
  cursor_.mended = 0;
  cursor_.settling = 0;
  cursor_.sweep = 0;
  links_->forget_all();
  equilibrium_->forget();
}

// Ends that going on would not change: a run that is taken up again ends so at once.
void Scheduler::end_for_good() {
  if (stop_ == Stop::kNone || stop_ == Stop::kIterations) return;
  cursor_.done = static_cast<std::uint32_t>(stop_);
  links_->forget_all();  // nothing will be gathered across them again
  if (directory_.store().contains(kEquilibriumRecord))
    directory_.store().drop_streamed(kEquilibriumRecord);
}

// Is the solution as exact as asked? If not, a local pass may make it so, and then finer links: as
// fine as the estimate says is needed, and no finer than the next level's. A coarse level's answer
// is taken where that is beyond doubt.
Status Scheduler::judge() {
  ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, true));
  for (const ClusterId c : order_) drop_mend(directory_.store(), c);
  const double asked = options_.error, found = summary_.estimate.error;
  const bool last = at_last_level(), finest = last && cursor_.threshold <= 1;
  const bool few = summary_.links < kFewLinks;
  const double finer = std::clamp(squared(asked / found), kTightest, kLoosest);
  if ((last ? found : summary_.estimate.high) <= asked && cursor_.level >= kFirstTaken) {
    const bool settled = cursor_.settling || cursor_.mended || cursor_.rest < kTakenRest ||
                         options_.links == "discard";
    if (settled) stop_ = Stop::kConverged;
    cursor_.settling = 1;
    cursor_.phase = Phase::kLinks;
  } else if (!cursor_.mended && (finest || (last && !few && found <= kMendedByPass * asked))) {
    cursor_.phase = Phase::kMeasure;
  } else if (!last) {
    begin_level(std::max(1.0, finer * kLevels[cursor_.level] / kLevels[cursor_.level + 1]));
  } else if (!finest) {
    begin_level(std::max(1 / cursor_.threshold, finer));
  } else if (cursor_.tightened == kMostTightened) {
    stop_ = Stop::kTooCoarse;
  } else {
    ++cursor_.tightened;
    begin_level(finer);
  }
  end_for_good();
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

void Scheduler::fill_summary() {
  const StoreCounters c = counters();
  summary_.reads = c.reads;
  summary_.writes = c.writes;
  summary_.evictions = c.evictions;
  summary_.reads_ahead = c.reads_ahead;
  summary_.streamed_bytes_read = c.streamed_bytes_read;
  summary_.streamed_bytes_written = c.streamed_bytes_written;
  summary_.bytes_read = c.bytes_read;
  summary_.bytes_written = c.bytes_written;
  summary_.io_seconds = c.io_seconds;
  summary_.stall_seconds = c.stall_seconds;
  summary_.store_bytes = directory_.store().live_bytes(RecordKind::kCluster);
  summary_.allocated_bytes = directory_.store().allocated_bytes();
  summary_.live_bytes = directory_.store().live_bytes();
  summary_.total_seconds = seconds();
  summary_.peak_rss_bytes = std::max(summary_.peak_rss_bytes, peak_rss());
}

// Everything durable; then the summary, which tells of that too, and a last small checkpoint, which
// knows the summary.
Status Scheduler::finish() {
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  directory_.end_trace();
  fill_summary();
  if (summary_.evictions == 0)
    summary_.left_out.push_back({"eviction", "everything fits into the arena"});
  ATRIUM_RETURN_IF_ERROR(directory_.files().write(RunFile::kSummary, summary_json(summary_)));
  summary_written_ = true;
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  return show(true);
}

Status Scheduler::prepare_all() {
  Result<Prepared> prepared = prepare(options_);
  if (!prepared.ok()) return prepared.status();
  prepared_.emplace(std::move(prepared).value());
  for (const std::string& w : prepared_->plan.warnings) say("warning: " + w);
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
  sweep_.gathered = order_.size();  // none is under way
  return {};
}

Result<SolveSummary> Scheduler::run() {
  ATRIUM_RETURN_IF_ERROR(validate(options_));
  ATRIUM_RETURN_IF_ERROR(open_run());
  ATRIUM_RETURN_IF_ERROR(prepare_all());
  ATRIUM_RETURN_IF_ERROR(take_up_run());
  const Model& model = prepared_->model;
  worlds_ = std::make_unique<RayWorlds>(model, directory_.store(), forces(options_, kRays) ? RayUse::kAlways
                                                                 : RayUse::kWhereSomethingMayBlock);
  fresh_ = std::make_unique<FreshGather>(model, directory_.store(), *worlds_);
  // Half of the memory holds links, the others are on disk: their bits are the same.
  const std::uint64_t budget = options_.links == "keep" ? ~std::uint64_t{0} : options_.memory / 2;
  links_ = std::make_unique<KeptLinks>(directory_.store(), model.clusters.size(), budget);
  ATRIUM_RETURN_IF_ERROR(show(true));
  const Status solved = iterate();
  if (!solved.ok()) stop_ = Stop::kFailed;
  summary_.stop_reason = reason(stop_);
  summary_.exit_code = solved.ok() ? exit_code(stop_) : static_cast<int>(solved.code());
  const Status finished = finish();  // what was done is kept, if the store still can
  if (!solved.ok()) return solved;
  if (!finished.ok()) return finished;
  return summary_;
}

}  // namespace

void request_stop() { stop_flag.store(true); }
void request_checkpoint() { checkpoint_flag.store(true); }

Result<SolveSummary> solve(const SolveOptions& options, const ProgressCallback& progress,
                           const LogCallback& log) {
  const int threads = options.threads > 0 ? options.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  return Scheduler(options, progress, log).run();
}

}  // namespace atrium
