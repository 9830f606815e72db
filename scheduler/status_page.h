// StatusPage: where a run stands, for other processes to look at: one page, the file `status` of
// the run directory, renewed as the solve goes on. No lock: the page bears its own hash, and a
// reader that meets a half-written one looks again.
//
// It is written and read in one call each and not through a mapping, so that it goes through the
// same Disk as everything else, and a full disk is an error and not a signal.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "engine/status.h"
#include "pagestore/disk.h"

namespace atrium {

enum class RunPhase : std::uint32_t { kPreparing, kSolving, kEnded };

struct RunStatus {
  std::int64_t process = 0;
  RunPhase phase = RunPhase::kPreparing;
  std::int32_t exit_code = -1;  // of kEnded
  std::uint64_t iteration = 0, gathered = 0, clusters = 0, elements = 0, links = 0;
  double seconds = 0, residual = -1, hit_ratio = -1;  // -1: not known yet
  std::uint64_t checkpoints = 0;
  double checkpoint_at = -1;  // s from the start: the last one; -1: none yet
  std::uint64_t peak_rss_bytes = 0;
};

class StatusPage {
 public:
  static Result<StatusPage> open(Disk& disk, const std::string& run_directory);
  Status write(const RunStatus& status);

 private:
  explicit StatusPage(std::unique_ptr<DiskFile> file) : file_(std::move(file)) {}
  std::unique_ptr<DiskFile> file_;
};

// None where no solve has written one. kStore: it is damaged.
Result<std::optional<RunStatus>> read_status(Disk& disk, const std::string& run_directory);

}  // namespace atrium
