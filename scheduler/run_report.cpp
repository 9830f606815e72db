#include "scheduler/run_report.h"

#include <sys/resource.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "scheduler/history.h"

namespace atrium {

namespace {

constexpr double kStatusInterval = 0.2;  // s between renewals of the status page and progress
constexpr double kHistoryInterval = 60;  // s between lines of an iteration that goes on

double cpu_now() { return double(std::clock()) / CLOCKS_PER_SEC; }

std::uint64_t peak_rss() {
  rusage u{};
  getrusage(RUSAGE_SELF, &u);
  return std::uint64_t(u.ru_maxrss) * 1024;
}

// The iteration that is under way, or the last one that was.
std::uint64_t current_iteration(const Cursor& cursor, const Sweep& sweep, std::uint64_t clusters) {
  return cursor.iteration + (sweep.gathered < clusters ? 1 : 0);
}

WorkingSetSteps steps(const WorkingSetCourse& course) {
  WorkingSetSteps s;
  for (std::size_t i = 0; i < course.gathers.size() && course.gathers[i] > 0; ++i) {
    s.largest.push_back(course.largest[i]);
    s.mean.push_back(course.sum[i] / course.gathers[i]);
  }
  return s;
}

std::string words(const HistoryLine& h, std::uint32_t level) {
  char text[256];
  std::snprintf(text, sizeof text,
                "iteration %llu level %u: residual %.3g, %llu elements, %llu links, %llu rays, "
                "hit ratio %.3f, error %.2f%%, %.1f s",
                static_cast<unsigned long long>(h.iteration), level, h.residual,
                static_cast<unsigned long long>(h.elements),
                static_cast<unsigned long long>(h.links), static_cast<unsigned long long>(h.rays),
                h.hit_ratio, 100 * h.estimate.error, h.seconds);
  return text;
}

}  // namespace

RunReport::RunReport(RunDirectory& directory, const ProgressCallback& progress,
                     const LogCallback& log)
    : directory_(directory), progress_(progress), log_(log), start_(now()), cpu_start_(cpu_now()) {}

double RunReport::cpu_seconds() const {
  return directory_.earlier().cpu_seconds + cpu_now() - cpu_start_;
}

void RunReport::say(const std::string& text) const {
  if (log_) log_(text);
}

Status RunReport::log(const std::string& text) {
  say(text);
  return directory_.files().append_line(RunFile::kLog, text);
}

// Once a run, by name: what its light does not pass though the scene leaves it open.
Status RunReport::log_gaps(const std::vector<NamedGap>& gaps) {
  std::string lines;
  for (const NamedGap& gap : gaps) {
    const std::string line = "closed gap: " + gap_words(gap);
    say(line);
    lines += (lines.empty() ? "" : "\n") + line;
  }
  return lines.empty() ? Status() : directory_.files().append_line(RunFile::kLog, lines);
}

void RunReport::begin(const Prepared& prepared) {
  summary_.scene = prepared.scene.files;
  summary_.patches = prepared.scene.patches;
  summary_.lights = prepared.scene.lights;
  summary_.clusters = prepared.model.clusters.size();
  summary_.cells = prepared.model.cells.size();
  summary_.portals = prepared.model.portals.size();
  summary_.left_out = prepared.plan.left_out;
  summary_.estimated = prepared.plan.estimated;
  summary_.threads = static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void RunReport::take_up(const RunState& earlier) {
  sweep_began_ = earlier.sweep_began;
  static_cast<SolveFigures&>(summary_) = earlier.figures;
  ++summary_.resumes;
  say("resumed after " + std::to_string(earlier.sweep.gathered) + " clusters of iteration " +
      std::to_string(current_iteration(earlier.cursor, earlier.sweep, gathers_to_)));
}

void RunReport::count_checkpoint(RunState& state) {
  ++summary_.checkpoints;
  state.figures = summary_;
  state.counters = counters();
  state.sweep_began = sweep_began_;
  state.seconds = seconds();
  state.cpu_seconds = cpu_seconds();
}

void RunReport::end_sweep(const Sweep& sweep) {
  const PushPullSums& s = sweep.sums;
  summary_.elements = sweep.elements;
  summary_.flux_emitted = luminance(s.emitted);
  summary_.flux_absorbed = luminance(s.absorbed);
  summary_.flux_escaped = luminance(s.escaped);
}

void RunReport::count_links(const Sweep& sweep, double residual) {
  summary_.residual = residual;
  summary_.links = sweep.links;
  summary_.max_working_set_bytes =
      std::max(summary_.max_working_set_bytes, sweep.working_set_bytes);
  summary_.max_working_set_links =
      std::max(summary_.max_working_set_links, sweep.working_set_links);
  summary_.max_working_set_elements =
      std::max(summary_.max_working_set_elements, sweep.working_set_elements);
  summary_.links_processed += sweep.links;
  summary_.refined.add(sweep.refined);
  summary_.total_data_bytes += sweep.total_bytes;
  summary_.hit_ratio = (counters() - sweep_began_).hit_ratio();
}

Status RunReport::show(const Cursor& cursor, const Sweep& sweep, bool at_once) {
  if (!at_once && now() - last_shown_ < kStatusInterval) return {};
  last_shown_ = now();
  const std::uint64_t clusters = gathers_to_;
  RunStatus status;
  status.process = ::getpid();
  status.phase = ended()                  ? RunPhase::kEnded
                 : summary_.clusters == 0 ? RunPhase::kPreparing
                                          : RunPhase::kSolving;
  if (ended()) status.exit_code = summary_.exit_code;
  status.iteration = current_iteration(cursor, sweep, clusters);
  status.gathered = sweep.gathered;
  status.clusters = clusters;
  status.elements = sweep.elements;
  status.links = sweep.links;
  status.seconds = seconds();
  if (last_line_.iteration > 0) status.residual = last_line_.residual;
  status.hit_ratio = (counters() - sweep_began_).hit_ratio();
  status.checkpoints = summary_.checkpoints;
  status.checkpoint_at = checkpoint_at_;
  status.peak_rss_bytes = peak_rss();
  ATRIUM_RETURN_IF_ERROR(directory_.write_status(status));
  if (!progress_ || ended()) return {};
  Progress p{status.iteration, sweep.gathered,      clusters, sweep.elements, sweep.links,
             seconds(),        last_line_.residual, -1};
  if (sweep.gathered > 0)
    p.eta_seconds = sweep.solver_seconds / sweep.gathered * (clusters - sweep.gathered);
  progress_(p);
  return {};
}

// When all links of a level have been made.
Status RunReport::log_links(const LinksKept& kept) {
  summary_.links_kept = kept;
  return log("links of " + std::to_string(kept.in_memory) + " clusters kept in memory (" +
             std::to_string(kept.in_memory_bytes) + " bytes), of " +
             std::to_string(kept.streamed) + " on disk (" + std::to_string(kept.streamed_bytes) +
             ")");
}

bool RunReport::line_due() const { return now() - last_line_at_ > kHistoryInterval; }

HistoryLine RunReport::line(const Cursor& cursor, const Sweep& sweep, bool complete) const {
  const StoreCounters c = counters() - sweep_began_;
  HistoryLine h;
  h.seconds = seconds();
  h.cpu_seconds = cpu_seconds();
  h.iteration = cursor.iteration + (complete ? 0 : 1);
  h.clusters_gathered = sweep.gathered;
  h.residual = cursor.residual;
  h.elements = complete ? summary_.elements : sweep.elements;
  h.links = complete ? summary_.links : sweep.links;
  h.rays = sweep.refined.rays;
  h.reads = c.reads;
  h.writes = c.writes;
  h.bytes_read = c.bytes_read;
  h.bytes_written = c.bytes_written;
  h.hit_ratio = c.hit_ratio();
  h.solver_seconds = sweep.solver_seconds;
  h.io_seconds = c.io_seconds;
  h.stall_seconds = c.stall_seconds;
  h.max_working_set_bytes = sweep.working_set_bytes;
  h.peak_rss_bytes = peak_rss();
  const bool across_links = sweep.working_set_bytes > 0;  // a local pass has no working sets
  if (complete && across_links) h.working_sets = steps(sweep.working_sets);
  return h;
}

Status RunReport::record(const HistoryLine& line, std::uint32_t level, bool complete) {
  last_line_ = line;
  last_line_at_ = now();
  if (complete) summary_.solver_seconds += line.solver_seconds;
  ATRIUM_RETURN_IF_ERROR(log(words(line, level)));
  return directory_.files().append_line(RunFile::kHistory, history_json(line));
}

Status RunReport::write_summary() {
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
  summary_.file_bytes = directory_.store().file_bytes();
  summary_.cpu_seconds = cpu_seconds();
  summary_.total_seconds = seconds();
  summary_.peak_rss_bytes = std::max(summary_.peak_rss_bytes, peak_rss());
  if (summary_.evictions == 0)
    summary_.left_out.push_back({"eviction", "everything fits into the arena"});
  return directory_.files().write(RunFile::kSummary, summary_json(summary_));
}

}  // namespace atrium
