#include "scheduler/solve.h"

#include <sys/resource.h>
#include <unistd.h>
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

#include "pagestore/trace_writer.h"
#include "scheduler/gather_cluster.h"
#include "scheduler/history.h"
#include "scheduler/order.h"
#include "scheduler/plan.h"
#include "scheduler/reference_points.h"
#include "scheduler/run_model.h"
#include "scheduler/run_state.h"
#include "scheduler/status_page.h"
#include "solver/element_tree.h"

namespace atrium {

namespace {

std::atomic<bool> stop_flag{false}, checkpoint_flag{false};

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

// Requests whose records are foreseen at a time; what is needed next is among them.
constexpr std::uint64_t kForesight = 1 << 16;
// The arena until the plan knows the run's own.
constexpr std::size_t kFirstArena = std::size_t{1} << 20;
constexpr double kStatusInterval = 0.2;    // s between renewals of the status page and progress
constexpr double kHistoryInterval = 60;    // s between lines of an iteration that goes on

enum class Stop { kNone, kConverged, kResidual, kIterations, kTime, kRequested, kStalled, kFailed };

const char* reason(Stop s) {
  switch (s) {
    case Stop::kConverged: return "converged";
    case Stop::kResidual: return "residual reached";
    case Stop::kIterations: return "iteration limit";
    case Stop::kTime: return "time limit";
    case Stop::kRequested: return "stopped on request";
    case Stop::kStalled: return "no longer converging";
    case Stop::kFailed: return "failed";
    case Stop::kNone: break;
  }
  return "";
}

int exit_code(Stop s) {
  if (s == Stop::kRequested) return static_cast<int>(Code::kStopped);
  if (s == Stop::kIterations || s == Stop::kTime || s == Stop::kStalled) return static_cast<int>(Code::kLimit);
  return 0;
}

// Tells one partitioned scene from another: shapes, who sees whom, and how all of it reflects and
// emits. Of what has no padding, so that equal scenes have equal ones.
std::uint64_t fingerprint(const Scene& scene, const Model& model) {
  std::vector<std::uint64_t> parts{model.clusters.size(), model.patches.size(), model.cells.size()};
  const auto add = [&](const auto& items) {
    parts.push_back(hash_bytes(std::as_bytes(std::span(items))));
  };
  add(model.vertices);
  add(model.portal_vertices);
  add(model.visible.starts);
  add(model.visible.items);
  std::vector<Spectrum> paint;
  for (const Patch& p : model.patches) {
    const Material& m = scene.materials[p.material.value];
    paint.push_back(m.reflectance);
    paint.push_back(m.exitance);
  }
  add(paint);
  return hash_bytes(std::as_bytes(std::span(parts)));
}
static_assert(std::has_unique_object_representations_v<ClusterId>);
static_assert(sizeof(Spectrum) == kChannels * sizeof(double) && sizeof(Vec3) == 3 * sizeof(double));

// The radiosity scheduler: "the conceptual center of the system". [THFH94 §4]
class Scheduler {
 public:
  Scheduler(const SolveOptions& options, const ProgressCallback& progress, const LogCallback& log)
      : options_(options),
        progress_(progress),
        log_(log),
        start_(now()),
        cpu_start_(cpu_now()),
        files_(options.disk != nullptr ? *options.disk : machine_disk(Io::kMmap),
               options.run_directory) {}

  Result<SolveSummary> run();

 private:
  // The run directory, its store and its state.
  Disk& disk() const;
  StoreOptions store_options(std::size_t arena) const;
  Status open_run();
  Status open_store(std::size_t arena);
  Status create_store();
  Status take_up_run(std::span<const std::byte> run_model);
  Status see_to_disk();
  Status begin_trace();
  void mark_trace();
  void end_trace();
  Status write_first_records(std::span<const std::byte> run_model);
  RunModel run_model() const;
  Status checkpoint();
  Status checkpoint_empty();
  Status checkpoint_if_due();

  // The iteration.
  Status prepare_all();
  Status iterate();
  Status sweep();
  GatherTask task_for(ClusterId receiver);
  void foresee_more();
  void end_sweep();
  void conclude();
  bool limits_reached();
  double rest_of_light(double change) const;
  double residual() const;
  bool stalled(double change);

  // What is told of it.
  Status record_history(std::uint32_t level, bool complete);
  Status show(bool now_at_once);
  void fill_summary();
  Status finish();
  StoreCounters counters() const { return earlier_.counters + store_->counters(); }
  double seconds() const { return earlier_.seconds + now() - start_; }
  double cpu_seconds() const { return earlier_.cpu_seconds + cpu_now() - cpu_start_; }
  void say(const std::string& text) {
    if (log_) log_(text);
  }

  const SolveOptions& options_;
  const ProgressCallback& progress_;
  const LogCallback& log_;
  const double start_, cpu_start_;
  RunFiles files_;
  std::optional<StatusPage> page_;
  std::unique_ptr<TraceWriter> trace_;  // null: nothing is recorded
  std::unique_ptr<ClusterStore> store_;
  RunState earlier_;  // as of the checkpoint that this process began with
  std::uint64_t model_hash_ = 0;
  bool begun_ = false;
  std::optional<Prepared> prepared_;
  std::optional<ReferencePoints> reference_;
  std::unique_ptr<RayWorlds> worlds_;
  std::vector<ClusterId> order_;
  std::unique_ptr<KeptLinks> links_;
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

Disk& Scheduler::disk() const {
  return options_.disk != nullptr ? *options_.disk : machine_disk(Io::kMmap);
}

StoreOptions Scheduler::store_options(std::size_t arena) const {
  StoreOptions store;
  store.arena_bytes = arena;
  store.policy = options_.policy;
  store.io = options_.io == "direct" ? Io::kDirect : Io::kMmap;
  store.disk = options_.disk;
  return store;
}

// The run directory is there before anything else: a run that is stopped from here on can be
// resumed. The store's arena is not yet the run's own.
Status Scheduler::open_run() {
  for (const std::string& f : options_.scene.files)
    if (!std::filesystem::exists(f))
      return Status(Code::kScene, f, "", "no such file", "check the path of the scene");
  ATRIUM_RETURN_IF_ERROR(open_store(kFirstArena));
  if (!store_) ATRIUM_RETURN_IF_ERROR(create_store());
  Result<StatusPage> page = StatusPage::open(disk(), options_.run_directory);
  if (!page.ok()) return page.status();
  page_.emplace(std::move(*page));
  return show(true);
}

// A store that is there, of this run, and its texts as they were left; none where none is, or its
// making was cut short.
Status Scheduler::open_store(std::size_t arena) {
  if (!ClusterStore::is_there(disk(), options_.run_directory)) return {};
  auto opened = ClusterStore::open(options_.run_directory, store_options(arena),
                                   options_.recover ? OpenMode::kRecover : OpenMode::kReadWrite);
  if (!opened.ok()) return opened.status();
  store_ = std::move(opened).value();
  if (!store_->recovery_note().ok()) say("warning: " + store_->recovery_note().message());
  const Result<RunState> state = run_state(store_->state(), options_.run_directory);
  if (!state.ok()) return state.status();
  earlier_ = *state;
  // Where nothing was begun its making may have been cut short, before run.toml or just after.
  if (!earlier_.begun && !files_.exists(RunFile::kToml)) return checkpoint_empty();
  if (earlier_.begun) ATRIUM_RETURN_IF_ERROR(files_.verify_all(earlier_.sums));
  const Result<std::string> there = files_.read(RunFile::kToml);
  if (!there.ok()) return there.status();
  if (*there == run_toml(options_)) return {};
  if (earlier_.begun)
    return Status(Code::kUsage, options_.run_directory, "run.toml",
                  "the directory holds another run", "give another directory with -o");
  return checkpoint_empty();  // nothing was begun here: it may become another run
}

Status Scheduler::create_store() {
  ATRIUM_RETURN_IF_ERROR(disk().make_directory(options_.run_directory));
  auto created = ClusterStore::create(options_.run_directory, store_options(kFirstArena),
                                      to_bytes(RunState()));
  if (!created.ok()) return created.status();
  store_ = std::move(created).value();
  return checkpoint_empty();
}

// run.toml, and a store that knows it.
Status Scheduler::checkpoint_empty() {
  ATRIUM_RETURN_IF_ERROR(files_.write(RunFile::kToml, run_toml(options_)));
  return checkpoint();
}

// With the run's own arena, as the plan has it by now.
Status Scheduler::take_up_run(std::span<const std::byte> run_model) {
  store_.reset();
  ATRIUM_RETURN_IF_ERROR(open_store(prepared_->plan.arena));
  ATRIUM_RETURN_IF_ERROR(begin_trace());
  model_hash_ = fingerprint(prepared_->scene, prepared_->model);
  if (!earlier_.begun) {
    ATRIUM_RETURN_IF_ERROR(see_to_disk());
    ATRIUM_RETURN_IF_ERROR(write_first_records(run_model));
    begun_ = true;
    return checkpoint();
  }
  if (earlier_.model_hash != model_hash_)
    return Status(Code::kUsage, options_.scene.files.front(), "",
                  "the scene is not the one that the run in " + options_.run_directory +
                      " was begun with",
                  "give back the scene as it was, or solve into another directory");
  begun_ = true;
  cursor_ = earlier_.cursor;
  sweep_ = earlier_.sweep;
  sweep_began_ = earlier_.sweep_began;
  static_cast<SolveFigures&>(summary_) = earlier_.figures;
  ++summary_.resumes;
  say("resumed after " + std::to_string(sweep_.gathered) + " clusters of iteration " +
      std::to_string(cursor_.iteration + (sweep_.gathered < order_.size() ? 1 : 0)));
  return {};
}

// Is the disk large enough? Before starting, and not after hours.
Status Scheduler::see_to_disk() {
  const Result<std::uint64_t> free = disk().free_bytes(options_.run_directory);
  if (!free.ok()) return free.status();
  const Plan& plan = prepared_->plan;
  const std::string there = std::to_string(*free) + " bytes are free";
  if (*free < plan.smallest_disk)
    return Status(Code::kStore, options_.run_directory, "",
                  there + ", and the solve cannot begin with less than " +
                      std::to_string(plan.smallest_disk),
                  "make room on that disk, or solve into a directory on another");
  if (*free < plan.disk)
    say("warning: " + options_.run_directory + ": " + there + ", and the solution is estimated at " +
        std::to_string(plan.disk) + "; if the disk fills up, make room and resume");
  return {};
}

// What was recorded before a stop stays: each part of a run that is resumed has a trace of its own.
Status Scheduler::begin_trace() {
  if (options_.trace.empty()) return {};
  std::string path = options_.trace;
  for (int part = 2; earlier_.begun && disk().exists(path); ++part)
    path = options_.trace + "." + std::to_string(part);
  Result<std::unique_ptr<TraceWriter>> trace = TraceWriter::create(path, disk());
  if (!trace.ok()) return trace.status();
  trace_ = std::move(*trace);
  store_->record_to(trace_.get());
  return {};
}

// A trace that could not be written ends early, and the solve goes on: it is what was asked for.
void Scheduler::end_trace() {
  if (!trace_) return;
  store_->record_to(nullptr);
  const Status closed = trace_->close();
  trace_.reset();
  if (!closed.ok()) say("warning: the trace is not whole: " + closed.message());
}

void Scheduler::mark_trace() {
  if (!trace_) return;
  const RecordId receiver = record_id(RecordKind::kCluster, order_[sweep_.gathered].value);
  if (sweep_.gathered == 0) trace_->iteration(cursor_.iteration + 1);
  trace_->gather(receiver, store_->size(receiver));
  if (!trace_->status().ok()) end_trace();
}

// Every cluster's record, its blockers, and the model: the database before the first gather.
Status Scheduler::write_first_records(std::span<const std::byte> run_model) {
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
  return store_run_model(run_model, *store_);
}

RunModel Scheduler::run_model() const {
  RunModel run;
  run.frame = prepared_->scene.frame;
  run.bounds = prepared_->scene.bounds;
  run.tolerance = prepared_->scene.tolerance;
  run.order = options_.basis;
  run.files = prepared_->scene.files;
  for (const Object& o : prepared_->scene.objects) run.object_names.push_back(o.name);
  for (const Material& m : prepared_->scene.materials) run.material_names.push_back(m.name);
  run.model = prepared_->model;
  return run;
}

// Between two gathers: all of the solve that is not a function of the scene and the options.
Status Scheduler::checkpoint() {
  if (links_ && !cursor_.done) ATRIUM_RETURN_IF_ERROR(links_->save());
  const Result<RunSums> sums = files_.sums();
  if (!sums.ok()) return sums.status();
  ++summary_.checkpoints;
  RunState state;
  state.begun = begun_;
  state.model_hash = model_hash_;
  state.cursor = cursor_;
  state.sweep = sweep_;
  state.figures = summary_;
  state.counters = counters();
  state.sweep_began = sweep_began_;
  state.seconds = seconds();
  state.cpu_seconds = cpu_seconds();
  state.sums = *sums;
  // An end writes it anew: the root before that must not hold on to the last one's sum.
  if (stop_ != Stop::kNone && !summary_written_)
    state.sums[static_cast<std::size_t>(RunFile::kSummary)] = {};
  // Twice: then both roots name the same records, and what only the root before named is free at
  // once instead of at the next checkpoint. The second one writes a directory and a state.
  for (int root = 0; root < 2; ++root)
    ATRIUM_RETURN_IF_ERROR(store_->checkpoint(to_bytes(state)));
  last_checkpoint_ = now();
  checkpoint_at_ = seconds();
  return {};
}

Status Scheduler::checkpoint_if_due() {
  const bool asked = checkpoint_flag.exchange(false);
  if (!asked && now() - last_checkpoint_ < options_.checkpoint_every) return {};
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  const std::string text = "checkpoint of epoch " + std::to_string(store_->epoch()) + ": " +
                           std::to_string(store_->live_bytes()) + " bytes live, " +
                           std::to_string(store_->allocated_bytes()) + " allocated";
  say(text);
  return files_.append_line(RunFile::kLog, text);
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
  t.links = links_.get();
  if (options_.links != "discard")
    t.linking = cursor_.sweep > 0 ? Linking::kUseKept : Linking::kMakeAndKeep;
  t.refine.threshold = kThresholdOfError * options_.error * kLevels[cursor_.level];
  t.refine.mean_irradiance = cursor_.mean_irradiance;
  t.refine.ambient = cursor_.iteration == 0 ? 0.5 * cursor_.mean_irradiance : 0;
  t.refine.reference_area = prepared_->light.reference_area;
  t.refine.min_edge = prepared_->plan.min_edge;
  t.refine.tolerance = prepared_->model.tolerance;
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

// The requests of the gathers to come, this iteration's and the next one's: R, then the sources that
// it reads.
void Scheduler::foresee_more() {
  std::vector<RecordId> requests;
  const std::size_t n = order_.size();
  while (store_->foreseen() + requests.size() < kForesight && foreseen_ahead_ < n) {
    const ClusterId receiver = order_[(sweep_.gathered + foreseen_ahead_) % n];
    requests.push_back(record_id(RecordKind::kCluster, receiver.value));
    for (const ClusterId s : prepared_->model.visible[receiver.value])
      if (s != receiver) requests.push_back(record_id(RecordKind::kCluster, s.value));
    ++foreseen_ahead_;
  }
  store_->foresee(requests);
}

// One complete gather to every cluster, or the rest of one.
Status Scheduler::sweep() {
  if (sweep_.gathered == order_.size()) {
    sweep_ = {};
    sweep_began_ = counters();
  }
  while (sweep_.gathered < order_.size()) {
    ATRIUM_RETURN_IF_ERROR(checkpoint_if_due());
    if (limits_reached()) return record_history(cursor_.level, false);
    foresee_more();
    mark_trace();
    const GatherTask task = task_for(order_[sweep_.gathered]);
    const Result<GatherReport> report =
        gather_cluster(prepared_->model, *store_, *worlds_, task);
    if (!report.ok()) return report.status();
    --foreseen_ahead_;
    sweep_.add(*report);
    ATRIUM_RETURN_IF_ERROR(show(false));
    if (now() - last_line_at_ > kHistoryInterval) ATRIUM_RETURN_IF_ERROR(record_history(cursor_.level, false));
  }
  // The iteration is over and its consequences drawn before anything can fail again.
  const std::uint32_t level = cursor_.level;
  ++cursor_.iteration;
  end_sweep();
  conclude();
  return record_history(level, true);
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
  ATRIUM_RETURN_IF_ERROR(page_->write(status));
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
  summary_.hit_ratio = (counters() - sweep_began_).hit_ratio();
}

Status Scheduler::record_history(std::uint32_t level, bool complete) {
  const StoreCounters c = counters() - sweep_began_;
  HistoryLine h;
  h.seconds = seconds();
  h.cpu_seconds = cpu_seconds();
  h.iteration = cursor_.iteration + (complete ? 0 : 1);
  h.clusters_gathered = sweep_.gathered;
  h.residual = residual();
  h.elements = sweep_.elements;
  h.links = sweep_.links;
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
  if (complete && reference_) {
    Result<double> e = reference_->error(prepared_->model, *store_);
    if (!e.ok()) return e.status();
    h.error_true = summary_.error_true = *e;
    store_->forget_foreseen();  // the points' records were read between
    foreseen_ahead_ = 0;
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
                static_cast<unsigned long long>(h.iteration), level, h.residual,
                static_cast<unsigned long long>(h.elements),
                static_cast<unsigned long long>(h.links), static_cast<unsigned long long>(h.rays),
                h.hit_ratio, h.seconds);
  say(text);
  ATRIUM_RETURN_IF_ERROR(files_.append_line(RunFile::kLog, text));
  return files_.append_line(RunFile::kHistory, history_json(h));
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
  const bool last = cursor_.level + 1 == kLevels.size();
  const PushPullSums& s = sweep_.sums;
  const double reflected = luminance(s.reflected);
  const double change = reflected > 0 ? s.change / reflected : 0;
  const double rest = rest_of_light(change);
  ++cursor_.sweep;
  cursor_.last_change = change;
  const bool no_progress = stalled(change);
  const bool settled = rest < (last ? kFineRestOfError * options_.error : kCoarseRest);
  if (last && options_.residual > 0 && residual() <= options_.residual)
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
    links_->forget_all();
  }
  // Ends that going on would not change: a run that is taken up again ends so at once.
  if (stop_ == Stop::kConverged || stop_ == Stop::kResidual || stop_ == Stop::kStalled) {
    cursor_.done = static_cast<std::uint32_t>(stop_);
    links_->forget_all();  // nothing will be gathered across them again
  }
}

// The loop over receivers "until convergence" [THFH94 §5.1], level by level.
Status Scheduler::iterate() {
  if (cursor_.done) stop_ = static_cast<Stop>(cursor_.done);
  if (options_.iterations && cursor_.iteration >= options_.iterations) stop_ = Stop::kIterations;
  while (stop_ == Stop::kNone) ATRIUM_RETURN_IF_ERROR(sweep());
  return {};
}

void Scheduler::fill_summary() {
  const StoreCounters c = counters();
  summary_.reads = c.reads;
  summary_.writes = c.writes;
  summary_.evictions = c.evictions;
  summary_.bytes_read = c.bytes_read;
  summary_.bytes_written = c.bytes_written;
  summary_.io_seconds = c.io_seconds;
  summary_.stall_seconds = c.stall_seconds;
  summary_.store_bytes = store_->live_bytes(RecordKind::kCluster);
  summary_.allocated_bytes = store_->allocated_bytes();
  summary_.live_bytes = store_->live_bytes();
  summary_.total_seconds = seconds();
  summary_.peak_rss_bytes = std::max(summary_.peak_rss_bytes, peak_rss());
}

// Everything durable; then the summary, which tells of that too, and a last small checkpoint, which
// knows the summary.
Status Scheduler::finish() {
  ATRIUM_RETURN_IF_ERROR(checkpoint());
  end_trace();
  fill_summary();
  if (summary_.evictions == 0)
    summary_.left_out.push_back({"eviction", "everything fits into the arena"});
  ATRIUM_RETURN_IF_ERROR(files_.write(RunFile::kSummary, summary_json(summary_)));
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
  ATRIUM_RETURN_IF_ERROR(take_up_run(to_bytes(run_model())));
  const Model& model = prepared_->model;
  worlds_ = std::make_unique<RayWorlds>(model, *store_);
  // Half of the memory holds links, the others are on disk: their bits are the same.
  const std::uint64_t budget = options_.links == "keep" ? ~std::uint64_t{0} : options_.memory / 2;
  links_ = std::make_unique<KeptLinks>(*store_, model.clusters.size(), budget);
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
