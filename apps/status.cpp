// atrium status RUN [--watch]: looks at a live or stopped run from another process.
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <thread>

#include "apps/command.h"
#include "apps/report_json.h"
#include "engine/quantity.h"

namespace atrium {
namespace {

constexpr std::chrono::seconds kBetweenLooks{1};

struct StatusCommand {
  std::vector<std::string> run;
  bool watch = false;
};

std::string progress_text(const RunStatus& s) {
  std::string text = "iteration " + std::to_string(s.iteration) + ", " +
                     std::to_string(s.gathered) + "/" + std::to_string(s.clusters) + " clusters, " +
                     std::to_string(s.elements) + " elements, " + std::to_string(s.links) +
                     " links, " + format_time(s.seconds);
  if (s.residual >= 0) text += ", residual " + format_share(s.residual);
  if (s.hit_ratio >= 0) text += ", hit ratio " + format_share(s.hit_ratio);
  if (const auto since = seconds_since_checkpoint(s))
    text += ", checkpoint " + std::to_string(s.checkpoints) + " " + format_time(*since) + " ago";
  return text;
}

// What became of it, or who is at it.
std::string life_text(const RunLook& look, const std::string& run) {
  const std::string goes_on = "`atrium resume " + run + "` goes on";
  switch (look.life) {
    case RunLife::kPreparing:
    case RunLife::kSolving:
      return to_string(look.life) + " (process " + std::to_string(*look.process) + ")";
    case RunLife::kEnded: {
      const bool stopped = look.page->exit_code == static_cast<int>(Code::kStopped);
      return "ended: " + (stopped ? "stopped on request; " + goes_on : look.stop_reason) +
             " (exit code " + std::to_string(look.page->exit_code) + ")";
    }
    case RunLife::kInterrupted:
      break;
  }
  return "interrupted, nobody works on it; " + goes_on;
}

std::string status_text(const RunLook& look, const std::string& run) {
  std::string text = run + ": " + life_text(look, run);
  if (look.page && look.life != RunLife::kPreparing) text += ": " + progress_text(*look.page);
  return text;
}

bool live(const RunLook& look) {
  return look.life == RunLife::kPreparing || look.life == RunLife::kSolving;
}

// A line that renews itself on a terminal, else a line whenever it changes.
class Lines {
 public:
  void show(const std::string& line) {
    if (line == last_) return;
    if (renews_ && !last_.empty()) std::cout << "\r\033[K";
    std::cout << line << (renews_ ? "" : "\n") << std::flush;
    last_ = line;
  }
  void end() { std::cout << (renews_ ? "\n" : "") << std::flush; }

 private:
  const bool renews_ = isatty(STDOUT_FILENO) != 0;
  std::string last_;
};

Result<int> run_status(const StatusCommand& command, const Global& global) {
  const std::string& run = command.run.front();
  Lines lines;
  while (std::cout) {
    const Result<RunLook> look = look_at_run(run);
    if (!look.ok()) return look.status();
    lines.show(global.json ? status_json(*look) : status_text(*look, run));
    if (!command.watch || !live(*look)) break;
    std::this_thread::sleep_for(kBetweenLooks);
  }
  lines.end();
  return 0;
}

}  // namespace

Command status_command() {
  auto options = std::make_shared<StatusCommand>();
  Command command{"status", "look at a live or stopped run from another process", {}, {}};
  command.options.argument("RUN", "a run directory", 1, 1, options->run);
  command.options.flag("watch", "look again every second until it ends", options->watch);
  command.run = [options](const Global& global, Console&) { return run_status(*options, global); };
  return command;
}

}  // namespace atrium
