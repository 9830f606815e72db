// Runs the program as a shell would, and keeps what it wrote and how it ended.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "test/folder.h"

namespace atrium::testing {

inline std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

inline void write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

struct Ended {
  int code = -1;
  std::string out, err;
};

inline std::string quoted(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

// before: "ATRIUM_RHO=0.25", or another program to run this one.
inline Ended run(const std::vector<std::string>& words, const std::string& before = "",
                 const std::string& input = "") {
  const Folder folder;
  write_file(folder / "in", input);
  std::string line = before + " " + quoted(ATRIUM_PROGRAM);
  for (const std::string& w : words) line += " " + quoted(w);
  line +=
      " <" + quoted(folder / "in") + " >" + quoted(folder / "out") + " 2>" + quoted(folder / "err");
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(folder / "out"),
          read_file(folder / "err")};
}

// A cube whose every surface has ρ = 1/2 and M = 100 lm/m²: B = M/(1-ρ) and E = B all over.
inline constexpr double kFurnaceRadiosity = 200;  // lm/m²
inline constexpr double kFurnaceSide = 3;         // m, from the origin

// A solved run of it, made once.
inline const std::string& furnace_run() {
  static const Folder folder;
  static const std::string path = [] {
    const std::string scene = folder / "cube.obj", run_directory = folder / "run";
    const Ended made = run({"gen", "furnace", "--rho", "0.5", "--emit", "100", "-o", scene});
    const Ended solved = run({"solve", scene, "-o", run_directory, "--memory", "64MiB"});
    return made.code == 0 && solved.code == 0 ? run_directory : "no run: " + made.err + solved.err;
  }();
  return path;
}

}  // namespace atrium::testing
