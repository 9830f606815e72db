// CoarseMatrix: the sparse rows of the coarse system (scheduler/equilibrium.h), one after the other
// in runs of memory that are never moved: a product goes through them once, in order, five times
// faster than through rows that each lie somewhere, and what they take is known.
//
// Not thread safe, apart from reading.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/element.h"

namespace atrium {

// What K holds of one receiving unit.
struct CoarseEntry {
  std::uint32_t unit = 0;                // the source
  std::array<float, kChannels> share{};  // of the source's mean E, in the receiver's
};
static_assert(sizeof(CoarseEntry) == 16);

class CoarseMatrix {
 public:
  explicit CoarseMatrix(std::size_t units = 0) : rows_(units) {}
  CoarseMatrix(CoarseMatrix&&) = default;  // rows point into runs, which stay where they are
  CoarseMatrix& operator=(CoarseMatrix&&) = default;

  std::size_t units() const { return rows_.size(); }
  std::span<const CoarseEntry> operator[](std::size_t unit) const { return rows_[unit]; }
  void set(std::size_t unit, std::span<const CoarseEntry> row);
  std::size_t bytes() const;

 private:
  std::span<CoarseEntry> take(std::size_t entries);
  void close_ranks();

  std::vector<std::span<CoarseEntry>> rows_;   // into the runs
  std::vector<std::vector<CoarseEntry>> runs_;  // as long as they were taken, filled as they go
  std::size_t live_ = 0, used_ = 0;             // entries: of rows; with what rows have left
};

}  // namespace atrium
