#include "apps/run_look.h"

#include "apps/report_json.h"
#include "pagestore/cluster_store.h"
#include "scheduler/run_files.h"

namespace atrium {
namespace {

RunLife life_of(const RunLook& look) {
  if (!look.process) {
    const bool ended = look.page && look.page->phase == RunPhase::kEnded;
    return ended ? RunLife::kEnded : RunLife::kInterrupted;
  }
  // A page that another process left tells nothing of this one, and one that has told of its end is
  // closing the store.
  const bool own = look.page && look.page->process == *look.process;
  if (!own || look.page->phase == RunPhase::kPreparing) return RunLife::kPreparing;
  return RunLife::kSolving;
}

}  // namespace

std::string to_string(RunLife life) {
  switch (life) {
    case RunLife::kPreparing:
      return "preparing";
    case RunLife::kSolving:
      return "solving";
    case RunLife::kEnded:
      return "ended";
    case RunLife::kInterrupted:
      break;
  }
  return "interrupted";
}

Result<RunLook> look_at_run(const std::string& run) {
  Disk& disk = machine_disk(Io::kMmap);
  RunLook look;
  look.process = lock_holder(lock_path(run));
  if (!look.process && !ClusterStore::is_there(disk, run))
    return Status(Code::kUsage, run, "", "not a run directory",
                  "give the directory that atrium solve wrote with -o");
  const Result<std::optional<RunStatus>> page = read_status(disk, run);
  if (!page.ok()) return page.status();
  look.page = *page;
  look.life = life_of(look);
  if (look.life != RunLife::kEnded) return look;
  const RunFiles files(disk, run);
  const Result<std::string> summary = files.read(RunFile::kSummary);
  if (!summary.ok()) return summary.status();
  Result<std::string> reason = stop_reason(*summary, files.path(RunFile::kSummary));
  if (!reason.ok()) return reason.status();
  look.stop_reason = std::move(*reason);
  return look;
}

std::optional<double> seconds_since_checkpoint(const RunStatus& status) {
  if (status.checkpoint_at < 0) return std::nullopt;
  return status.seconds - status.checkpoint_at;
}

}  // namespace atrium
