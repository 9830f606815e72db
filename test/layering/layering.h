// Layering: which folder may include which, and where each third-party library enters. What is
// checked is the text of the sources, `#include` lines as they stand, compiled or not.
//
//   engine <- pagestore
//   engine <- visibility <- solver
//   engine <- data
//   engine, pagestore, visibility, solver <- scheduler
//   all of these <- apps
//   test/F sees what F sees, libraries too, and data for its scenes; test/physics, test/agree,
//   test/layering and bench see everything; nobody includes test, and only test/bench bench.
// Pure functions but for read_sources.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace atrium {

struct SourceFile {
  std::string path;  // from the repository's root, with slashes
  std::string text;
};

// All .h, .cpp and .inc files of the repository's folders, sorted by path.
std::vector<SourceFile> read_sources(const std::filesystem::path& root);

// One line for each include that may not be, "path:line: what is wrong"; empty if all is well.
std::vector<std::string> layering_violations(std::span<const SourceFile> sources);

}  // namespace atrium
