// Arena: the fixed memory that records live in. Its addresses are taken when it is made, its pages
// as records first come to lie in them, and none is given back while it lives: a small scene takes
// of a large arena what it needs.
//
// Invariants:
//  1. Never grows: an allocation that finds no hole fails.
//  2. Slots are whole granules, best fit; nothing moves but by resize and move.
// Not thread safe; the bytes of distinct slots may be used from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "engine/status.h"
#include "pagestore/extent.h"
#include "pagestore/record.h"

namespace atrium {

class Arena {
 public:
  static Result<std::unique_ptr<Arena>> make(std::size_t bytes);  // rounded down to granules
  ~Arena();
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  std::optional<std::uint64_t> allocate(std::uint64_t granules);  // the slot's first granule
  void free(std::uint64_t slot, std::uint64_t granules);

  // Gives a slot another size, in place if it can, else wherever a hole, its own place counted as
  // free, is large enough; moves what fits of its content. nullopt, and nothing changed, if there
  // is none.
  std::optional<std::uint64_t> resize(std::uint64_t slot, std::uint64_t granules,
                                      std::uint64_t new_granules);

  // Moves a slot to where it may overlap its old place; the rest of the new one must be free.
  void move(std::uint64_t slot, std::uint64_t granules, std::uint64_t to);

  std::span<std::byte> image(std::uint64_t slot, std::uint64_t granules) const {
    return {memory_ + slot * kGranule, granules * kGranule};
  }

  std::uint64_t granules() const { return granules_; }
  std::uint64_t free_granules() const { return holes_.free_granules(); }
  std::uint64_t used_granules() const { return granules_ - free_granules(); }
  std::uint64_t peak_granules() const { return peak_; }

 private:
  Arena(std::byte* memory, std::uint64_t granules);
  void note_peak();

  std::byte* memory_;
  std::uint64_t granules_;
  std::uint64_t peak_ = 0;
  FreeMap holes_;
};

}  // namespace atrium
