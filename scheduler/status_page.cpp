#include "scheduler/status_page.h"

#include <array>
#include <chrono>
#include <cstring>
#include <thread>
#include <type_traits>

#include "pagestore/record.h"

namespace atrium {

namespace {

constexpr std::array<char, 8> kMagic{'A', 'T', 'R', 'I', 'U', 'M', 'S', '1'};

struct Page {
  std::array<char, 8> magic = kMagic;
  RunStatus status;
  std::array<std::byte, kGranule - sizeof(RunStatus) - 16> zero{};
  std::uint64_t hash = 0;  // XXH3-64 of all before
};
static_assert(sizeof(Page) == kGranule && std::is_trivially_copyable_v<Page>);

std::string page_path(const std::string& directory) { return directory + "/status"; }

std::uint64_t hash_of(const Page& page) {
  return hash_bytes(std::as_bytes(std::span(&page, 1)).first(offsetof(Page, hash)));
}

bool whole(const Page& page) { return page.magic == kMagic && page.hash == hash_of(page); }

}  // namespace

Result<StatusPage> StatusPage::open(Disk& disk, const std::string& directory) {
  auto file = disk.open(page_path(directory), DiskAccess::kReadWrite);
  if (!file.ok()) return file.status();
  return StatusPage(std::move(*file));
}

Status StatusPage::write(const RunStatus& status) {
  Page page;
  page.status = status;
  page.hash = hash_of(page);
  return write_all(*file_, 0, std::as_bytes(std::span(&page, 1)));
}

Result<std::optional<RunStatus>> read_status(Disk& disk, const std::string& directory) {
  constexpr int kAttempts = 10;
  constexpr std::chrono::milliseconds kBetween{2};
  const std::string path = page_path(directory);
  if (!disk.exists(path)) return std::optional<RunStatus>();
  auto file = disk.open(path, DiskAccess::kRead);
  if (!file.ok()) return file.status();
  const auto size = (*file)->size();
  if (!size.ok()) return size.status();
  if (*size == 0) return std::optional<RunStatus>();
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Page page;
    ATRIUM_RETURN_IF_ERROR((*file)->read(0, std::as_writable_bytes(std::span(&page, 1))));
    if (whole(page)) return std::optional(page.status);
    std::this_thread::sleep_for(kBetween);
  }
  return Status(Code::kStore, path, "", "it does not match its hash",
                "remove it: it tells of the run's progress and holds nothing else");
}

}  // namespace atrium
