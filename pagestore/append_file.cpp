#include "pagestore/append_file.h"

#include <filesystem>
#include <system_error>

namespace atrium {
namespace {

// Unlinking /dev/null would be a poor way to begin.
bool is_special(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored);
}

}  // namespace

Result<AppendFile> AppendFile::create(const std::string& path, Disk& disk) {
  if (is_special(path))
    return Status(Code::kUsage, path, "", "is no plain file", "name a file to be made");
  if (disk.exists(path)) ATRIUM_RETURN_IF_ERROR(disk.remove(path));
  auto file = disk.open(path, DiskAccess::kReadWrite);
  if (!file.ok()) return file.status();
  return AppendFile(std::move(*file));
}

Status AppendFile::append(std::span<const std::byte> bytes) {
  if (!status_.ok()) return status_;
  status_ = write_all(*file_, size_, bytes);
  if (status_.ok()) size_ += bytes.size();
  return status_;
}

Status AppendFile::append(const std::string& text) {
  return append(std::as_bytes(std::span(text)));
}

Status AppendFile::close() {
  if (!status_.ok()) return status_;
  status_ = file_->sync();
  return status_;
}

}  // namespace atrium
