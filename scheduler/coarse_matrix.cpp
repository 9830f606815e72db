#include "scheduler/coarse_matrix.h"

#include <algorithm>

namespace atrium {

namespace {

constexpr std::size_t kRunEntries = std::size_t{1} << 15;  // 512 KiB

}  // namespace

std::span<CoarseEntry> CoarseMatrix::take(std::size_t entries) {
  if (runs_.empty() || runs_.back().capacity() - runs_.back().size() < entries) {
    runs_.emplace_back();
    runs_.back().reserve(std::max(entries, kRunEntries));
  }
  std::vector<CoarseEntry>& run = runs_.back();
  const std::size_t first = run.size();
  run.resize(first + entries);  // within its capacity: nothing moves
  used_ += entries;
  return std::span(run).subspan(first, entries);
}

// Rows that were replaced by longer ones have left holes.
void CoarseMatrix::close_ranks() {
  std::vector<std::vector<CoarseEntry>> before;
  before.swap(runs_);
  used_ = 0;
  for (std::span<CoarseEntry>& row : rows_) {
    const std::span<CoarseEntry> place = take(row.size());
    std::ranges::copy(row, place.begin());
    row = place;
  }
}

void CoarseMatrix::set(std::size_t unit, std::span<const CoarseEntry> row) {
  std::span<CoarseEntry>& place = rows_[unit];
  live_ -= place.size();
  if (row.size() > place.size()) {
    place = {};
    if (used_ > 2 * live_ + kRunEntries) close_ranks();
    place = take(row.size());
  }
  place = place.first(row.size());
  live_ += row.size();
  std::ranges::copy(row, place.begin());
}

std::size_t CoarseMatrix::bytes() const {
  std::size_t entries = 0;
  for (const std::vector<CoarseEntry>& run : runs_) entries += run.capacity();
  return rows_.size() * sizeof(rows_[0]) + entries * sizeof(CoarseEntry);
}

}  // namespace atrium
