#include "scheduler/run_files.h"

#include <algorithm>

#include "pagestore/record.h"

namespace atrium {

namespace {

constexpr std::array<const char*, kRunFiles> kNames{"run.toml", "history.jsonl", "run.log",
                                                    "summary.json"};

constexpr std::array<RunFile, kRunFiles> kAll{RunFile::kToml, RunFile::kHistory, RunFile::kLog,
                                              RunFile::kSummary};

std::size_t index(RunFile file) { return static_cast<std::size_t>(file); }

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

FileSum sum_of(const std::string& text) { return {text.size(), hash_bytes(bytes_of(text))}; }

bool is_of_lines(RunFile file) { return file == RunFile::kHistory || file == RunFile::kLog; }

// Of the lines that are whole: what is behind them is a line cut short, and will be cut off.
std::size_t whole_lines(const std::string& text) { return text.rfind('\n') + 1; }  // npos + 1 is 0

}  // namespace

const char* RunFiles::name(RunFile file) { return kNames[index(file)]; }

Status RunFiles::final_if_failed(Status sync) {
  if (failed_.ok()) failed_ = sync;
  return sync;
}

Status RunFiles::write(RunFile file, const std::string& text) {
  const std::string made = path(file) + ".new";
  if (disk_.exists(made)) ATRIUM_RETURN_IF_ERROR(disk_.remove(made));
  {
    auto opened = disk_.open(made, DiskAccess::kReadWrite);
    if (!opened.ok()) return opened.status();
    ATRIUM_RETURN_IF_ERROR(write_all(**opened, 0, bytes_of(text)));
    ATRIUM_RETURN_IF_ERROR(final_if_failed((*opened)->sync()));
  }
  ATRIUM_RETURN_IF_ERROR(disk_.rename(made, path(file)));
  return final_if_failed(disk_.sync_directory(directory_));
}

Status RunFiles::append_line(RunFile file, const std::string& line) {
  std::string text;
  if (exists(file)) {
    Result<std::string> there = read(file);
    if (!there.ok()) return there.status();
    text = std::move(*there);
  }
  auto opened = disk_.open(path(file), DiskAccess::kReadWrite);
  if (!opened.ok()) return opened.status();
  const std::size_t whole = whole_lines(text);
  if (whole < text.size()) ATRIUM_RETURN_IF_ERROR((*opened)->truncate(whole));
  return write_all(**opened, whole, bytes_of(line + "\n"));
}

Result<std::string> read_text(Disk& disk, const std::string& path) {
  auto opened = disk.open(path, DiskAccess::kRead);
  if (!opened.ok()) return opened.status();
  const auto size = (*opened)->size();
  if (!size.ok()) return size.status();
  std::string text(*size, '\0');
  ATRIUM_RETURN_IF_ERROR((*opened)->read(0, std::as_writable_bytes(std::span(text))));
  return text;
}

Result<RunSums> RunFiles::sums() {
  if (!failed_.ok()) return failed_;
  RunSums sums;
  for (const RunFile file : kAll) {
    if (!exists(file)) continue;
    Result<std::string> text = read(file);
    if (!text.ok()) return text.status();
    if (is_of_lines(file)) text->resize(whole_lines(*text));
    sums[index(file)] = sum_of(*text);
    auto opened = disk_.open(path(file), DiskAccess::kReadWrite);
    if (!opened.ok()) return opened.status();
    ATRIUM_RETURN_IF_ERROR(final_if_failed((*opened)->sync()));
  }
  ATRIUM_RETURN_IF_ERROR(final_if_failed(disk_.sync_directory(directory_)));
  return sums;
}

Status RunFiles::verify(RunFile file, const RunSums& sums) const {
  const FileSum& known = sums[index(file)];
  if (known.length == 0) return {};
  Result<std::string> text = read(file);
  if (!text.ok()) return text.status();
  if (text->size() == known.length || (is_of_lines(file) && text->size() > known.length)) {
    text->resize(known.length);
    if (sum_of(*text).hash == known.hash) return {};
  }
  return Status(Code::kStore, path(file), "",
                "it is not what the run wrote (" + std::to_string(known.length) +
                    " bytes of it do not match their hash)",
                "restore it from a copy, or solve again");
}

Status RunFiles::verify_all(const RunSums& sums) const {
  for (const RunFile file : kAll) ATRIUM_RETURN_IF_ERROR(verify(file, sums));
  return {};
}

}  // namespace atrium
