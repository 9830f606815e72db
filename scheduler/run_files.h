// RunFiles: the texts that a run leaves beside its page store, for people and other programs:
// run.toml, history.jsonl, run.log, summary.json. They go through the store's Disk, so that what
// fails there is an error here.
//
// Invariants:
//  1. A file that is written whole is either the old or the new one, whatever happens meanwhile.
//  2. Lines are appended whole; a line that a crash cut short is cut off when the next is appended.
//  3. Each checkpoint's state holds the sums of these files: what was changed behind the run's back
//     is found by verify().
//  4. After a failed sync no sums are taken any more: no later one brings down what it left.
// Not thread safe.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "engine/status.h"
#include "pagestore/disk.h"

namespace atrium {

enum class RunFile { kToml, kHistory, kLog, kSummary };
inline constexpr std::size_t kRunFiles = 4;

// Of the first `length` bytes of a file; a file that is not there has none.
struct FileSum {
  std::uint64_t length = 0, hash = 0;
};
using RunSums = std::array<FileSum, kRunFiles>;

Result<std::string> read_text(Disk& disk, const std::string& path);

class RunFiles {
 public:
  RunFiles(Disk& disk, std::string directory) : disk_(disk), directory_(std::move(directory)) {}

  static const char* name(RunFile file);
  std::string path(RunFile file) const { return directory_ + "/" + name(file); }
  bool exists(RunFile file) const { return disk_.exists(path(file)); }

  Status write(RunFile file, const std::string& text);         // whole, durable on return
  Status append_line(RunFile file, const std::string& line);   // durable with the next sums()
  Result<std::string> read(RunFile file) const { return read_text(disk_, path(file)); }

  // Of all files as they are now, which are durable on return.
  Result<RunSums> sums();
  // What the files held when `sums` were taken they hold still; lines may have come since. kStore,
  // naming the file, where not.
  Status verify(RunFile file, const RunSums& sums) const;
  Status verify_all(const RunSums& sums) const;

 private:
  Status final_if_failed(Status sync);

  Disk& disk_;
  std::string directory_;
  Status failed_;  // the first sync that did
};

}  // namespace atrium
