// A command of the program: its words, its options, and what it does. One file a command;
// atrium.cpp lists them. run() is called once, after every option has its value.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "apps/console.h"
#include "apps/options.h"
#include "engine/import/import.h"
#include "engine/status.h"
#include "visibility/partition.h"

namespace atrium {

inline constexpr std::uint64_t kMostThreads = 1024;

// What holds for every command.
struct Global {
  bool json = false, quiet = false, verbose = false;
  int threads = 0;  // 0: all there are
  std::string log;
};

struct Command {
  std::string name, help;
  OptionSet options;
  // Errors as a Status; else the exit code (a limit that solve reached is no error).
  std::function<Result<int>(const Global&, Console&)> run;
};

// Bytes for cluster records while a solution is read.
inline constexpr std::size_t kReadingArena = 64u << 20;

Command gen_command();
Command inspect_command();
Command plan_command();
Command solve_command();
Command resume_command();
Command status_command();
Command stop_command();
Command check_command();
Command probe_command();
Command reference_command();
Command render_command();
Command export_command();
Command report_command();
Command formfactor_command();
Command trace_command();
Command validate_command();

// Reads the command line, the environment and the configuration file, runs the command, and returns
// the exit code. Prints errors as "atrium: ...".
int run_command_line(int argc, char** argv, const std::vector<Command>& commands,
                     const std::string& version);

// The options that say how scene files are read.
void add_scene_options(OptionSet& options, ImportOptions& scene);

// The options that say how their space is divided.
void add_partition_options(OptionSet& options, PartitionOptions& partition);

// "atrium 0.1.0 ...": the build and the libraries.
std::string version_text();

inline Status usage_error(std::string cause, std::string remedy) {
  return Status(Code::kUsage, "", "", std::move(cause), std::move(remedy));
}

}  // namespace atrium
