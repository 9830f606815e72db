// Console: messages to people, on stderr and in the log of --log; data never goes through it.
// Progress is one line that renews itself on a terminal, else a plain line a minute.
// Safe to call from any thread.
#pragma once

#include <cstdio>
#include <functional>
#include <mutex>
#include <string>

#include "engine/status.h"

namespace atrium {

class Console {
 public:
  enum class Level { kQuiet, kNormal, kVerbose };
  // log_file: "" for none; else appended to.
  static Status open(Level level, const std::string& log_file, Console& console);

  Console() = default;
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void error(const std::string& message);   // always
  void say(const std::string& message);     // unless -q
  void detail(const std::string& message);  // with -v; in the log always
  // `text` is called only when a line is due.
  void progress(double seconds, const std::function<std::string()>& text);

 private:
  void print(const std::string& message, bool shown);
  void end_progress_line();

  std::mutex mutex_;
  Level level_ = Level::kNormal;
  std::FILE* log_ = nullptr;
  bool terminal_ = false;
  bool line_open_ = false;        // a progress line stands unfinished on the terminal
  double next_progress_ = 0;      // s
  double next_log_progress_ = 0;  // s
};

}  // namespace atrium
