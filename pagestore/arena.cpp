#include "pagestore/arena.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "engine/check.h"

namespace atrium {

Result<std::unique_ptr<Arena>> Arena::make(std::size_t bytes) {
  const std::uint64_t granules = bytes / kGranule;
  if (granules == 0)
    return Status(Code::kUsage, "arena", "", "it is smaller than one granule",
                  "give it at least " + std::to_string(kGranule) + " bytes");
  const std::size_t whole = granules * kGranule;
  void* memory = ::mmap(nullptr, whole, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED)
    return Status(Code::kUsage, "arena", "",
                  "no " + std::to_string(whole) +
                      " bytes of memory: " + std::generic_category().message(errno),
                  "give a smaller arena");
  // Where the kernel has large pages a fault brings in two megabytes; where not, nothing is lost.
  (void)::madvise(memory, whole, MADV_HUGEPAGE);
  return std::unique_ptr<Arena>(new Arena(static_cast<std::byte*>(memory), granules));
}

Arena::Arena(std::byte* memory, std::uint64_t granules) : memory_(memory), granules_(granules) {
  holes_.free(0, granules);
}

Arena::~Arena() { ::munmap(memory_, granules_ * kGranule); }

void Arena::note_peak() { peak_ = std::max(peak_, used_granules()); }

std::optional<std::uint64_t> Arena::allocate(std::uint64_t granules) {
  const auto slot = holes_.allocate(granules);
  note_peak();
  return slot;
}

void Arena::free(std::uint64_t slot, std::uint64_t granules) { holes_.free(slot, granules); }

std::optional<std::uint64_t> Arena::resize(std::uint64_t slot, std::uint64_t granules,
                                           std::uint64_t new_granules) {
  if (new_granules < granules) holes_.free(slot + new_granules, granules - new_granules);
  const bool in_place =
      new_granules <= granules || holes_.take(slot + granules, new_granules - granules);
  if (in_place) {
    note_peak();
    return slot;
  }
  holes_.free(slot, granules);
  const auto moved = holes_.allocate(new_granules);
  if (!moved) {
    ATRIUM_CHECK(holes_.take(slot, granules));
    return std::nullopt;
  }
  note_peak();
  std::memmove(image(*moved, granules).data(), image(slot, granules).data(), granules * kGranule);
  return moved;
}

void Arena::move(std::uint64_t slot, std::uint64_t granules, std::uint64_t to) {
  holes_.free(slot, granules);
  ATRIUM_CHECK(holes_.take(to, granules));
  std::memmove(image(to, granules).data(), image(slot, granules).data(), granules * kGranule);
}

}  // namespace atrium
