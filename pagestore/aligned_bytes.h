// AlignedBytes: scratch of whole granules, aligned to one, so that it can be read into and written
// from past the page cache. Grows as asked, and what it held is lost then.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>

#include "engine/check.h"
#include "pagestore/record.h"

namespace atrium {

class AlignedBytes {
 public:
  std::span<std::byte> granules(std::uint64_t count) {
    const std::size_t bytes = count * kGranule;
    if (bytes > size_) {
      bytes_.reset();
      bytes_.reset(static_cast<std::byte*>(std::aligned_alloc(kGranule, bytes)));
      ATRIUM_CHECK(bytes_ != nullptr);
      size_ = bytes;
    }
    return {bytes_.get(), bytes};
  }
  std::size_t size() const { return size_; }

 private:
  struct Free {
    void operator()(std::byte* bytes) const { std::free(bytes); }
  };
  std::unique_ptr<std::byte, Free> bytes_;
  std::size_t size_ = 0;
};

}  // namespace atrium
