// atrium solve SCENE -o RUN: the main job.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>

#include "apps/solve_options.h"
#include "engine/quantity.h"

namespace atrium {
namespace {

constexpr int kSignalBase = 128;  // of the exit codes of what a signal ended, as shells have it

std::string progress_text(const Progress& p) {
  std::string text = format_time(p.seconds) + "  iteration " + std::to_string(p.iteration) + "  " +
                     std::to_string(p.gathered) + "/" + std::to_string(p.clusters) + " clusters  " +
                     std::to_string(p.elements) + " elements  " + std::to_string(p.links) +
                     " links";
  if (p.residual > 0) text += "  residual " + format_share(p.residual);
  if (p.eta_seconds >= 0) text += "  " + format_time(p.eta_seconds) + " left";
  return text;
}

void say_summary(const SolveSummary& s, const std::string& run, Console& console) {
  console.say(run + ": " + s.stop_reason);
  console.say("  " + std::to_string(s.iterations) + " iterations in " +
              format_time(s.total_seconds) + ", " + std::to_string(s.elements) + " elements, " +
              std::to_string(s.links) + " links, residual " + format_share(s.residual));
  console.say("  largest working set " + format_size(s.max_working_set_bytes) + " of " +
              format_size(s.total_data_bytes) + " in all, hit ratio " + format_share(s.hit_ratio) +
              ", peak memory " + format_size(s.peak_rss_bytes));
  if (s.error_true >= 0) console.say("  true error " + format_share(s.error_true));
  for (const LeftOut& l : s.left_out) console.detail("  left out " + l.feature + ": " + l.why);
}

// The summary as the run directory holds it.
Result<std::string> summary_text(const std::string& run) {
  const std::string path = run + "/summary.json";
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in || text.empty())
    return Status(Code::kStore, path, "", "could not be read", "see that the disk has room");
  return text;
}

// timeout(1) and some supervisors signal the process and then its group: one request, heard twice.
constexpr std::int64_t kOneRequestNs = 50'000'000;

std::int64_t monotonic_ns() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);  // async-signal-safe
  return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
}

// The first INT or TERM asks for a checkpoint and an end; a second one leaves at once.
std::atomic<std::int64_t> asked_at{0};  // 0: not yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "used in a signal handler");

extern "C" void on_stop_signal(int signal) {
  const std::int64_t now = monotonic_ns();
  std::int64_t first = 0;
  if (asked_at.compare_exchange_strong(first, now)) {
    request_stop();
  } else if (now - first > kOneRequestNs) {
    _exit(kSignalBase + signal);
  }
}

extern "C" void on_checkpoint_signal(int) { request_checkpoint(); }

void hear_signals() {
  struct sigaction action {};
  action.sa_handler = on_stop_signal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  action.sa_handler = on_checkpoint_signal;
  sigaction(SIGUSR1, &action, nullptr);
}

// What a user should hear of without having asked.
void tell(const std::string& line, Console& console) {
  const bool matters = line.starts_with("warning:") || line.starts_with("resumed");
  matters ? console.say(line) : console.detail(line);
}

}  // namespace

Result<int> run_solve(const SolveOptions& options, const Global& global, Console& console) {
  hear_signals();
  const Result<SolveSummary> summary = solve(
      options,
      [&](const Progress& p) { console.progress(p.seconds, [&] { return progress_text(p); }); },
      [&](const std::string& line) { tell(line, console); });
  if (!summary.ok()) return summary.status();
  say_summary(*summary, options.run_directory, console);
  if (global.json) {
    const Result<std::string> text = summary_text(options.run_directory);
    if (!text.ok()) return text.status();
    std::cout << *text;
  }
  return summary->exit_code;
}

Command solve_command() {
  auto options = std::make_shared<SolveOptions>();
  Command command{"solve", "compute the light in a scene", {}, {}};
  add_solve_options(command.options, *options);
  command.run = [options](const Global& global, Console& console) -> Result<int> {
    if (options->run_directory.empty())
      return usage_error("solve needs -o RUN", "name the run directory to make");
    options->threads = global.threads;
    return run_solve(*options, global, console);
  };
  return command;
}

}  // namespace atrium
