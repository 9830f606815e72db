#include "pagestore/machine_file.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <system_error>

namespace atrium {

namespace {

constexpr mode_t kFileMode = 0644;

}  // namespace

std::string byte_place(std::uint64_t offset) { return "byte " + std::to_string(offset); }

std::string remedy_for(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "make room on that disk and resume";
    case EACCES:
    case EPERM:
    case EROFS:
      return "make it readable and writable for this user";
    case ENOENT:
      return "check the path";
    case EMFILE:
    case ENFILE:
      return "raise the limit of open files";
    default:
      return "check the disk; what the last checkpoint holds is intact";
  }
}

Status failure(const std::string& path, const std::string& place, const std::string& doing,
               int error) {
  return Status(Code::kStore, path, place,
                doing + " failed: " + std::generic_category().message(error), remedy_for(error));
}

Status ends_early(const std::string& path, std::uint64_t size, std::uint64_t end) {
  return Status(Code::kStore, path, byte_place(size),
                "the file ends here, before byte " + std::to_string(end),
                "restore the file from a copy, or solve again");
}

Result<std::uint64_t> MachineFile::size() const {
  struct stat s;
  if (::fstat(fd_.get(), &s) != 0) return failure(path_, "", "fstat", errno);
  return static_cast<std::uint64_t>(s.st_size);
}

Status MachineFile::allocate(std::uint64_t size) {
  int error = EINTR;  // posix_fallocate returns the error and leaves errno alone
  while (error == EINTR) error = ::posix_fallocate(fd_.get(), 0, static_cast<off_t>(size));
  if (error != 0) return failure(path_, "", "reserving " + std::to_string(size) + " bytes", error);
  return {};
}

Status MachineFile::sync() {
  if (retry_interrupted([&] { return ::fdatasync(fd_.get()); }) != 0)
    return failure(path_, "", "fdatasync", errno);
  return {};
}

Descriptor open_descriptor(const std::string& path, DiskAccess access, int flags) {
  flags |= O_CLOEXEC | (access == DiskAccess::kRead ? O_RDONLY : O_RDWR | O_CREAT);
  return Descriptor(::open(path.c_str(), flags, kFileMode));
}

}  // namespace atrium
