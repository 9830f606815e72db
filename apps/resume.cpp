// atrium resume RUN: goes on after a stop or a crash, with the options that the run was begun with.
#include <filesystem>
#include <memory>

#include "apps/solve_options.h"
#include "scheduler/run_state.h"

namespace atrium {
namespace {

// Takes up the store, from the older root where the newest does not verify, and with it the sum of
// run.toml, which is believed only then.
Status verify_run_toml(const std::string& run, Console& console) {
  StoreOptions options;
  options.arena_bytes = kGranule;  // no record is read
  const auto store = ClusterStore::open(run, options, OpenMode::kRecover);
  if (!store.ok()) return store.status();
  const Status& note = (*store)->recovery_note();
  if (!note.ok()) console.say("warning: " + note.message());
  const Result<RunState> state = run_state((*store)->state(), run);
  if (!state.ok()) return state.status();
  return RunFiles(machine_disk(Io::kMmap), run).verify(RunFile::kToml, state->sums);
}

Result<int> run_resume(const std::string& run, const Global& global, Console& console) {
  if (!std::filesystem::is_directory(run))
    return Status(Code::kUsage, run, "", "not a run directory",
                  "give the directory that atrium solve wrote with -o");
  ATRIUM_RETURN_IF_ERROR(verify_run_toml(run, console));
  SolveOptions options;
  options.run_directory = run;
  options.recover = true;
  ATRIUM_RETURN_IF_ERROR(read_run_toml(run + "/" + RunFiles::name(RunFile::kToml), options));
  if (global.threads != 0 && global.threads != options.threads)
    return usage_error("--threads is not what the run was begun with",
                       "leave it out: resume goes on as solve began");
  return run_solve(options, global, console);
}

}  // namespace

Command resume_command() {
  auto words = std::make_shared<std::vector<std::string>>();
  Command command{"resume", "go on after a stop or a crash", {}, {}};
  command.options.argument("RUN", "a run directory", 1, 1, *words);
  command.run = [words](const Global& global, Console& console) {
    return run_resume(words->front(), global, console);
  };
  return command;
}

}  // namespace atrium
