#include "apps/console.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace atrium {
namespace {

constexpr double kTerminalInterval = 0.2;  // s between renewals of the line
constexpr double kPlainInterval = 60;      // s between plain lines

}  // namespace

Status Console::open(Level level, const std::string& log_file, Console& console) {
  console.level_ = level;
  console.terminal_ = isatty(STDERR_FILENO) != 0;
  console.next_progress_ = console.terminal_ ? kTerminalInterval : kPlainInterval;
  console.next_log_progress_ = kPlainInterval;
  if (log_file.empty()) return {};
  console.log_ = std::fopen(log_file.c_str(), "a");
  if (console.log_ == nullptr)
    return Status(Code::kUsage, log_file, "", std::strerror(errno),
                  "name a log file that can be written");
  return {};
}

Console::~Console() {
  end_progress_line();
  if (log_ != nullptr) std::fclose(log_);
}

void Console::end_progress_line() {
  if (line_open_) std::fputc('\n', stderr);
  line_open_ = false;
}

void Console::print(const std::string& message, bool shown) {
  const std::lock_guard lock(mutex_);
  if (shown) {
    end_progress_line();
    std::fprintf(stderr, "%s\n", message.c_str());
  }
  if (log_ != nullptr) {
    std::fprintf(log_, "%s\n", message.c_str());
    std::fflush(log_);
  }
}

void Console::error(const std::string& message) { print("atrium: " + message, true); }
void Console::say(const std::string& message) { print(message, level_ != Level::kQuiet); }
void Console::detail(const std::string& message) { print(message, level_ == Level::kVerbose); }

void Console::progress(double seconds, const std::function<std::string()>& text) {
  const std::lock_guard lock(mutex_);
  if (seconds >= next_progress_ && level_ != Level::kQuiet) {
    next_progress_ = seconds + (terminal_ ? kTerminalInterval : kPlainInterval);
    std::fprintf(stderr, terminal_ ? "\r\033[K%s" : "%s\n", text().c_str());
    std::fflush(stderr);
    line_open_ = terminal_;
  }
  if (log_ != nullptr && seconds >= next_log_progress_) {
    next_log_progress_ = seconds + kPlainInterval;
    std::fprintf(log_, "%s\n", text().c_str());
    std::fflush(log_);
  }
}

}  // namespace atrium
