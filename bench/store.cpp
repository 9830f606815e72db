// The program behind bench/store: one contender, one job, in a process of its own, so that it can
// be held to a memory limit from outside. A job prints one line of fields parted by tabs.
//
//   store_bench contenders            name, its data's name, "rewrites" or "-", title; a line each
//   store_bench make NAME DIR         writes all records
//   store_bench reads NAME A|B DIR    logical MB/s, hit ratio or "-", MB from the device, peak MB
//   store_bench rewrites NAME DIR     logical MB/s, device bytes a logical byte, worst commit in ms
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numeric>

#include "bench/contender.h"
#include "engine/stopwatch.h"

namespace atrium {

namespace {

constexpr double kMega = 1e6;
constexpr double kMilli = 1e3;
constexpr std::size_t kMadeBetweenCommits = std::size_t{256} << 20;  // bytes

// Rewrites: each pass replaces each of these records by a larger one, up to its full size.
constexpr RecordIndex kRewritten = 2'500;
constexpr std::uint64_t kPasses = 10;
constexpr double kSizeAtFirst = .6;

// A line "name: number" of /proc/self/io: bytes that went to or came from the device.
double device_bytes(const std::string& name) {
  std::ifstream lines("/proc/self/io");
  std::string word;
  for (double bytes = 0; lines >> word >> bytes;)
    if (word == name + ":") return bytes;
  return 0;
}

double peak_memory() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024;
}

// Leaves nothing of these files in the page cache, whoever read or wrote them.
void make_cold(const std::string& dir) {
  for (const auto& file : std::filesystem::recursive_directory_iterator(dir)) {
    if (!file.is_regular_file()) continue;
    const int fd = ::open(file.path().c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) continue;
    ::fdatasync(fd);
    ::posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED);
    ::close(fd);
  }
}

Status read_checked(Contender& contender, RecordIndex record, std::size_t size) {
  const auto bytes = contender.read(record);
  if (!bytes.ok()) return bytes.status();
  if (is_record(*bytes, record, size)) return {};
  return Status(Code::kStore, "", "record " + std::to_string(record), "another record came back");
}

Status make(Contender& contender) {
  Payloads payloads;
  std::size_t since_commit = 0;
  for (RecordIndex i = 0; i < kRecords; ++i) {
    ATRIUM_RETURN_IF_ERROR(contender.write(i, payloads.make(i, 0, record_sizes()[i])));
    since_commit += record_sizes()[i];
    if (since_commit < kMadeBetweenCommits) continue;
    ATRIUM_RETURN_IF_ERROR(contender.commit());
    since_commit = 0;
  }
  return contender.commit();
}

Status reads(Contender& contender, Order order) {
  const std::vector<RecordIndex> asked = requests(order);
  const double device_before = device_bytes("read_bytes");
  double bytes = 0;
  const Stopwatch watch;
  contender.foresee(asked);
  for (const RecordIndex record : asked) {
    ATRIUM_RETURN_IF_ERROR(read_checked(contender, record, record_sizes()[record]));
    bytes += static_cast<double>(record_sizes()[record]);
  }
  const double seconds = watch.seconds();
  const auto hits = contender.hit_ratio();
  std::printf("%.1f\t%s\t%.0f\t%.0f\n", bytes / kMega / seconds,
              hits ? std::to_string(*hits).c_str() : "-",
              (device_bytes("read_bytes") - device_before) / kMega, peak_memory() / kMega);
  return {};
}

std::size_t size_in_pass(RecordIndex record, std::uint64_t pass) {
  const double share =
      kSizeAtFirst + (1 - kSizeAtFirst) * static_cast<double>(pass) / static_cast<double>(kPasses);
  return static_cast<std::size_t>(share * static_cast<double>(record_sizes()[record]));
}

// A pass over all of them, as an iteration makes: each is read, grows, and is written; then a
// commit.
Status rewrite_pass(Contender& contender, Payloads& payloads, std::uint64_t pass) {
  std::vector<RecordIndex> all(kRewritten);
  std::iota(all.begin(), all.end(), 0);
  if (pass > 0) contender.foresee(all);
  for (RecordIndex i = 0; i < kRewritten; ++i) {
    if (pass > 0) ATRIUM_RETURN_IF_ERROR(read_checked(contender, i, size_in_pass(i, pass - 1)));
    ATRIUM_RETURN_IF_ERROR(contender.write(i, payloads.make(i, pass, size_in_pass(i, pass))));
  }
  return {};
}

Status rewrites(Contender& contender) {
  Payloads payloads;
  ATRIUM_RETURN_IF_ERROR(rewrite_pass(contender, payloads, 0));
  ATRIUM_RETURN_IF_ERROR(contender.commit());
  const double device_before = device_bytes("write_bytes");
  double bytes = 0, worst_commit = 0;
  const Stopwatch watch;
  for (std::uint64_t pass = 1; pass <= kPasses; ++pass) {
    ATRIUM_RETURN_IF_ERROR(rewrite_pass(contender, payloads, pass));
    const Stopwatch commit_watch;
    ATRIUM_RETURN_IF_ERROR(contender.commit());
    worst_commit = std::max(worst_commit, commit_watch.seconds());
    for (RecordIndex i = 0; i < kRewritten; ++i)
      bytes += static_cast<double>(size_in_pass(i, pass));
  }
  const double seconds = watch.seconds();
  std::printf("%.1f\t%.3f\t%.1f\n", bytes / kMega / seconds,
              (device_bytes("write_bytes") - device_before) / bytes, worst_commit * kMilli);
  for (RecordIndex i = 0; i < kRewritten; ++i)
    ATRIUM_RETURN_IF_ERROR(read_checked(contender, i, size_in_pass(i, kPasses)));
  return {};
}

void list() {
  for (const ContenderKind& kind : contenders())
    std::cout << kind.name << '\t' << kind.data << '\t' << (kind.rewrites ? "rewrites" : "-")
              << '\t' << kind.title << '\n';
}

Status usage() {
  return Status(Code::kUsage, "store_bench", "", "no such job or contender",
                "see the head of bench/store.cpp");
}

Status run(const std::vector<std::string>& words) {
  if (words == std::vector<std::string>{"contenders"}) {
    list();
    return {};
  }
  if (words.size() < 3) return usage();
  const std::string &job = words[0], &dir = words.back();
  const auto kinds = contenders();
  const auto kind = std::ranges::find(kinds, words[1], &ContenderKind::name);
  const bool reading = job == "reads" && words.size() == 4 && (words[2] == "A" || words[2] == "B");
  if (kind == kinds.end() ||
      !(reading || ((job == "make" || job == "rewrites") && words.size() == 3)))
    return usage();
  if (reading) make_cold(dir);
  const Purpose purpose = reading         ? Purpose::kRead
                          : job == "make" ? Purpose::kMake
                                          : Purpose::kRewrite;
  auto contender = kind->open(dir, purpose);
  if (!contender.ok()) return contender.status();
  if (reading) return reads(**contender, words[2] == "A" ? Order::kA : Order::kB);
  return purpose == Purpose::kMake ? make(**contender) : rewrites(**contender);
}

}  // namespace

Status not_whole(const std::string& dir, RecordIndex record) {
  return Status(Code::kStore, dir, "record " + std::to_string(record), "it came back damaged");
}

std::vector<ContenderKind> contenders() {
  std::vector<ContenderKind> kinds{pread_contender()};
#ifdef ATRIUM_BENCH_LMDB
  kinds.push_back(lmdb_contender());
#endif
#ifdef ATRIUM_BENCH_ROCKSDB
  kinds.push_back(rocksdb_contender());
#endif
  for (ContenderKind& ours : atrium_contenders()) kinds.push_back(std::move(ours));
  return kinds;
}

}  // namespace atrium

int main(int count, char** words) {
  const atrium::Status status = atrium::run({words + 1, words + count});
  if (!status.ok()) std::cerr << "store_bench: " << status.message() << '\n';
  return static_cast<int>(status.code());
}
