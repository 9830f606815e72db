#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <random>

#include "apps/export/formats.h"
#include "pagestore/record.h"
#include "scheduler/check_run.h"
#include "test/apps/program.h"

namespace atrium::testing {
namespace {

constexpr std::uint64_t kSeed = 1;
constexpr int kFlipsOfSmallFiles = 40, kFlipsOfPages = 150;

std::string solved_run(const Folder& folder) {
  const std::string scene = folder / "cornell.obj", directory = folder / "run";
  EXPECT_EQ(run({"gen", "cornell", "-o", scene}).code, 0);
  const Ended e = run({"solve", scene, "-o", directory, "--error", "20%", "--memory", "64MiB"});
  EXPECT_EQ(e.code, 0) << e.err;
  return directory;
}

std::string exported(const std::string& directory, const Folder& folder) {
  const auto solution = Solution::open(directory, std::size_t{1} << 20);
  if (!solution.ok()) return "no solution: " + solution.status().message();
  const auto written = write_csv(**solution, folder / "solution.csv");
  return written.ok() ? read_file(folder / "solution.csv") : written.status().message();
}

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

// Which granules of pages.* the two roots name, from the bytes alone, as pagestore/FORMAT.md has
// them.
class NamedGranules {
 public:
  explicit NamedGranules(const std::string& directory) : directory_(directory) {
    const std::string roots = read_file(directory + "/roots");
    for (const std::size_t slot : {std::size_t{0}, kGranule}) take_root(roots, slot);
  }
  bool holds(std::uint64_t segment, std::uint64_t byte) const {
    const std::uint64_t granule = byte / kGranule;
    for (const Extent& e : extents_)
      if (e.segment == segment && granule >= e.first && granule < e.first + e.granules) return true;
    return false;
  }
  std::size_t extents() const { return extents_.size(); }

 private:
  static constexpr std::size_t kDirectory = 40, kState = 80;  // in a root
  static constexpr std::size_t kEntry = 48, kHeader = 64;

  struct Extent {
    std::uint64_t segment, first, granules;
  };
  const Extent& take(std::uint64_t address, std::uint64_t length) {
    extents_.push_back(
        {address >> 32, address & 0xffffffff, (kHeader + length + kGranule - 1) / kGranule});
    return extents_.back();
  }
  void take_root(const std::string& roots, std::size_t slot) {
    const auto field = [&](std::size_t at) { return number_at<std::uint64_t>(roots, slot + at); };
    take(field(kState), field(kState + 8));
    const std::uint64_t length = field(kDirectory + 8);
    const Extent directory = take(field(kDirectory), length);
    char name[16];
    std::snprintf(name, sizeof name, "pages.%04u", static_cast<unsigned>(directory.segment));
    const std::string pages = read_file(directory_ + "/" + name);
    const std::string entries = pages.substr(directory.first * kGranule + kHeader, length);
    for (std::size_t at = 0; at < length; at += kEntry)
      take(number_at<std::uint64_t>(entries, at + 32), number_at<std::uint64_t>(entries, at + 8));
  }

  std::string directory_;
  std::vector<Extent> extents_;
};

// A byte of a file with one bit turned, until the end of its life.
class Flip {
 public:
  Flip(std::string path, std::uint64_t byte, int bit) : path_(std::move(path)), byte_(byte) {
    std::fstream file(path_, std::ios::binary | std::ios::in);
    file.seekg(std::streamoff(byte_));
    was_ = static_cast<char>(file.get());
    put(static_cast<char>(was_ ^ (1 << bit)));
  }
  ~Flip() { put(was_); }
  Flip(const Flip&) = delete;
  Flip& operator=(const Flip&) = delete;

 private:
  void put(char c) const {
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(std::streamoff(byte_));
    file.put(c);
  }
  std::string path_;
  std::uint64_t byte_;
  char was_ = 0;
};

TEST(Check, AFlippedBitAnywhereInTheRunDirectoryIsReportedOrLiesInFreeSpace) {
  const Folder folder;
  const std::string directory = solved_run(folder);
  const NamedGranules named(directory);
  const std::string whole = exported(directory, folder);
  ASSERT_TRUE(check_run(directory).ok()) << check_run(directory).status().message();
  std::mt19937_64 random(kSeed);
  int reported = 0, free = 0;
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  ASSERT_EQ(names.size(), 8u + std::count_if(names.begin(), names.end(), [](const std::string& n) {
                            return n.rfind("pages.", 0) == 0 && n != "pages.0000";
                          }));
  for (const std::string& name : names) {
    const std::string path = directory + "/" + name;
    const bool pages = name.rfind("pages.", 0) == 0;
    const std::uint64_t segment = pages ? std::stoul(name.substr(6)) : 0;
    for (int i = 0; i < (pages ? kFlipsOfPages : kFlipsOfSmallFiles); ++i) {
      const std::uint64_t byte = random() % std::filesystem::file_size(path);
      const Flip flip(path, byte, static_cast<int>(random() % 8));
      const Result<RunCheck> check = check_run(directory);
      const bool means_nothing = name == "lock" || (pages && !named.holds(segment, byte));
      ASSERT_EQ(check.ok(), means_nothing) << name << " byte " << byte;
      if (!check.ok()) {
        ++reported;
        EXPECT_EQ(check.status().code(), Code::kStore);
        EXPECT_EQ(check.status().file(), path) << check.status().message();
        EXPECT_NE(check.status().remedy(), "");
      } else {
        ++free;
        EXPECT_EQ(exported(directory, folder), whole) << name << " byte " << byte;
      }
    }
  }
  EXPECT_GT(reported, 6 * kFlipsOfSmallFiles);  // records too, and not texts and roots alone
  EXPECT_GT(free, kFlipsOfSmallFiles);          // more than the lock
  EXPECT_TRUE(check_run(directory).ok());
}

TEST(Check, PageFileThatEndsEarlyIsAFaultAndNoRunIsAUsageError) {
  const Folder folder;
  const std::string directory = solved_run(folder);
  const RunCheck check = *check_run(directory);
  EXPECT_TRUE(check.begun);
  EXPECT_EQ(check.roots, 2u);
  EXPECT_EQ(check.unsummed_bytes, 0u);
  std::filesystem::resize_file(directory + "/pages.0000", kGranule);
  EXPECT_EQ(check_run(directory).status().code(), Code::kStore);
  EXPECT_EQ(check_run(folder / "none").status().code(), Code::kUsage);
  std::filesystem::create_directory(folder / "empty");
  EXPECT_EQ(check_run(folder / "empty").status().code(), Code::kStore);
}

TEST(Check, LinesSinceTheLastCheckpointMustBeJson) {
  const Folder folder;
  const std::string directory = solved_run(folder);
  const std::string history = read_file(directory + "/history.jsonl");
  const std::string more = "{\"iteration\": 99}\n{\"iter";  // whole, and one that is being written
  write_file(directory + "/history.jsonl", history + more);
  const Result<RunCheck> check = check_run(directory);
  ASSERT_TRUE(check.ok()) << check.status().message();
  EXPECT_EQ(check->unsummed_bytes, more.size());
  write_file(directory + "/history.jsonl", history + "{\"iteration: 99}\n");
  const Status fault = check_run(directory).status();
  EXPECT_EQ(fault.file(), directory + "/history.jsonl");
  const auto lines = std::count(history.begin(), history.end(), '\n');
  EXPECT_EQ(fault.place(), "line " + std::to_string(lines + 1));
}

}  // namespace
}  // namespace atrium::testing
