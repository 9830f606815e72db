#include "pagestore/disk.h"

#include <cerrno>

#include "engine/check.h"
#include "pagestore/machine_file.h"

namespace atrium {

Status write_all(DiskFile& file, std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const auto written = file.write_some(offset, bytes);
    if (!written.ok()) return written.status();
    if (*written == 0)
      return Status(Code::kStore, file.path(), byte_place(offset), "a write took no bytes",
                    remedy_for(EIO));
    ATRIUM_CHECK(*written <= bytes.size());
    offset += *written;
    bytes = bytes.subspan(*written);
  }
  return {};
}

}  // namespace atrium
