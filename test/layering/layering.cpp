#include "test/layering/layering.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <string_view>

namespace atrium {

namespace {

using Names = std::set<std::string, std::less<>>;

// A folder and what it may include besides itself.
const std::map<std::string, Names, std::less<>>& folders() {
  static const std::map<std::string, Names, std::less<>> kFolders{
      {"engine", {}},
      {"pagestore", {"engine"}},
      {"visibility", {"engine"}},
      {"solver", {"engine", "visibility"}},
      {"scheduler", {"engine", "pagestore", "visibility", "solver"}},
      {"data", {"engine"}},
      {"apps", {"engine", "pagestore", "visibility", "solver", "scheduler", "data"}},
  };
  return kFolders;
}

// A library, how its headers begin, and the folders it enters in.
struct Library {
  std::string name, headers;
  Names folders;
};

const std::vector<Library>& libraries() {
  static const std::vector<Library> kLibraries{
      {"Boost", "boost/", {"pagestore"}},
      {"Clipper", "polyclipping/", {"engine", "visibility"}},
      {"CLI11", "CLI/", {"apps"}},
      {"Embree", "embree", {"visibility"}},
      {"GLM", "glm/", {"engine"}},
      {"Google Test", "gtest/", {"test"}},
      {"liburing", "liburing", {"pagestore"}},
      {"LMDB", "lmdb.h", {"bench"}},
      {"libpng", "png.h", {"apps"}},
      {"nlohmann-json", "nlohmann/", {"scheduler", "apps"}},
      {"oneTBB", "tbb/", {"visibility", "solver", "scheduler", "apps"}},
      {"oneTBB", "oneapi/tbb", {"visibility", "solver", "scheduler", "apps"}},
      {"OpenEXR", "Imf", {"apps"}},
      {"OpenEXR", "OpenEXR/", {"apps"}},
      {"OpenMesh", "OpenMesh/", {"engine"}},
      {"tinygltf", "tiny_gltf", {"engine", "apps"}},
      {"RocksDB", "rocksdb/", {"bench"}},
      {"toml++", "toml++/", {"engine", "apps"}},
      {"xxHash", "xxhash", {"pagestore", "bench"}},
  };
  return kLibraries;
}

// The one header that shows a library's types: vectors are GLM's everywhere.
constexpr std::string_view kVectorHeader = "engine/vec.h";

// Folders that never see a disk, and the headers that would show them one.
const Names kDiskless{"visibility", "solver"};
const Names kDiskHeaders{"filesystem", "fstream",    "fcntl.h",
                         "unistd.h",   "sys/mman.h", "sys/stat.h"};

// Headers of the machine: POSIX and C.
const Names kMachine{"errno.h",       "fcntl.h",        "fnmatch.h",      "poll.h",
                     "pthread.h",     "signal.h",       "stdlib.h",       "termios.h",
                     "unistd.h",      "linux/falloc.h", "sys/file.h",     "sys/ioctl.h",
                     "sys/mman.h",    "sys/random.h",   "sys/resource.h", "sys/stat.h",
                     "sys/statvfs.h", "sys/time.h",     "sys/types.h",    "sys/uio.h",
                     "sys/utsname.h", "sys/vfs.h",      "sys/wait.h",     "sys/prctl.h",
                     "malloc.h",      "immintrin.h"};

struct Include {
  std::size_t line;
  bool quoted;
  std::string header;
};

std::vector<Include> includes_of(const std::string& text) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*(["<])([^">]+)[">])re");
  std::vector<Include> found;
  std::istringstream lines(text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    std::smatch match;
    if (std::regex_search(line, match, kInclude))
      found.push_back({number, match[1] == "\"", match[2]});
  }
  return found;
}

std::string first_part(std::string_view path) {
  return std::string(path.substr(0, path.find('/')));
}

// The folder whose rules a file obeys; none where all is allowed. test/solver/… obeys solver's.
std::optional<std::string> ruling_folder(const std::string& path) {
  std::string folder = first_part(path);
  if (folder == "test") folder = first_part(std::string_view(path).substr(5));
  if (!folders().contains(folder)) return std::nullopt;
  return folder;
}

// "" where the file at `path` may include the repository's own `header`.
std::string own_fault(const std::string& path, const std::string& header) {
  const std::string from = first_part(path), to = first_part(header);
  if (to == "test" || to == "bench") return from == to ? "" : from + " may not include " + to;
  if (header.find('/') == std::string::npos || !folders().contains(to))
    return "not rooted at the repository, \"folder/file.h\"";
  const std::optional<std::string> rules = ruling_folder(path);
  if (!rules || to == *rules || folders().at(*rules).contains(to)) return "";
  if (from == "test" && to == "data") return "";
  return from + " may not include " + to;
}

// "" where the file at `path` may include a library's or the machine's `header`.
std::string foreign_fault(const std::string& path, const std::string& header) {
  const std::string from = first_part(path);
  if (kDiskless.contains(from) && kDiskHeaders.contains(header)) return from + " never sees a disk";
  const bool standard = header.find_first_of("./") == std::string::npos;
  if (standard || kMachine.contains(header)) return "";
  const auto library = std::ranges::find_if(
      libraries(), [&](const Library& l) { return header.starts_with(l.headers); });
  if (library == libraries().end()) return "of no library that test/layering knows";
  const std::string folder = ruling_folder(path).value_or(from);
  if (!library->folders.contains(from) && !library->folders.contains(folder))
    return library->name + " does not enter in " + folder;
  const bool may_show = path == kVectorHeader && library->name == "GLM";
  if (from != "test" && !may_show && !path.ends_with(".cpp"))
    return "a header shows " + library->name;
  return "";
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

}  // namespace

std::vector<SourceFile> read_sources(const std::filesystem::path& root) {
  static const Names kEndings{".h", ".cpp", ".inc"};
  std::vector<SourceFile> sources;
  std::vector<std::string> tops{"test", "bench"};
  for (const auto& [folder, allowed] : folders()) tops.push_back(folder);
  for (const std::string& top : tops) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / top)) {
      if (!kEndings.contains(entry.path().extension().string())) continue;
      sources.push_back({std::filesystem::relative(entry.path(), root).generic_string(),
                         read_file(entry.path())});
    }
  }
  std::ranges::sort(sources, {}, &SourceFile::path);
  return sources;
}

std::vector<std::string> layering_violations(std::span<const SourceFile> sources) {
  std::vector<std::string> violations;
  for (const SourceFile& source : sources) {
    for (const Include& include : includes_of(source.text)) {
      const std::string fault = include.quoted ? own_fault(source.path, include.header)
                                               : foreign_fault(source.path, include.header);
      if (!fault.empty())
        violations.push_back(source.path + ":" + std::to_string(include.line) + ": " +
                             include.header + ": " + fault);
    }
  }
  return violations;
}

}  // namespace atrium
