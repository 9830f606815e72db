// atrium stop RUN: asks a live run to checkpoint and stop, and waits until it has.
#include <signal.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <thread>

#include "apps/command.h"
#include "apps/run_look.h"
#include "engine/quantity.h"
#include "pagestore/disk.h"

namespace atrium {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kBetweenLooks{20};
constexpr double kTimeout = 600;  // s

struct Stop {
  std::vector<std::string> run;
  double timeout = kTimeout;
};

// False where it still runs then.
bool wait_for_end(const std::string& run, long process, double timeout) {
  const auto until = Clock::now() + std::chrono::duration<double>(timeout);
  while (lock_holder(lock_path(run)) == process) {
    if (Clock::now() >= until) return false;
    std::this_thread::sleep_for(kBetweenLooks);
  }
  return true;
}

std::string end_text(const RunLook& look, const std::string& run) {
  if (look.life != RunLife::kEnded)
    return "it ended without a last checkpoint: `atrium resume " + run +
           "` goes on from the one before";
  if (look.page->exit_code == static_cast<int>(Code::kStopped))
    return "stopped with a checkpoint: `atrium resume " + run + "` goes on";
  return "it had come to its end: " + look.stop_reason;
}

Result<int> run_stop(const Stop& stop, Console& console) {
  const std::string& run = stop.run.front();
  const Result<RunLook> look = look_at_run(run);
  if (!look.ok()) return look.status();
  if (!look->process) {
    console.say(run + ": nobody works on it, there is nothing to stop");
    return 0;
  }
  const long process = *look->process;
  if (process <= 0)  // kill(2) would take it for a group
    return Status(Code::kStore, lock_path(run), "", "it does not hold a process id",
                  "end the process that runs atrium yourself");
  if (kill(static_cast<pid_t>(process), SIGTERM) != 0 && errno != ESRCH)
    return Status(Code::kInternal, run, "process " + std::to_string(process), std::strerror(errno),
                  "stop it as the user who began it");
  if (!wait_for_end(run, process, stop.timeout))
    return Status(Code::kInternal, run, "process " + std::to_string(process),
                  "it was asked to stop, and still runs after " + format_time(stop.timeout),
                  "it will stop after the cluster at hand: wait with a longer --timeout");
  const Result<RunLook> ended = look_at_run(run);
  if (!ended.ok()) return ended.status();
  console.say(run + ": " + end_text(*ended, run));
  return 0;
}

}  // namespace

Command stop_command() {
  auto options = std::make_shared<Stop>();
  Command command{"stop", "ask a live run to checkpoint and stop", {}, {}};
  command.options.argument("RUN", "a run directory", 1, 1, options->run);
  command.options.time("timeout", "how long to wait for it (10min)", options->timeout);
  command.run = [options](const Global&, Console& console) { return run_stop(*options, console); };
  return command;
}

}  // namespace atrium
