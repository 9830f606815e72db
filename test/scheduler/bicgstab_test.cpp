#include "scheduler/bicgstab.h"

#include <gtest/gtest.h>

#include "scheduler/coarse_matrix.h"

namespace atrium::testing {
namespace {

// A matrix that is not symmetric, another one a channel: the answer put in must come out.
TEST(Bicgstab, EveryChannelFindsItsOwnAnswer) {
  constexpr std::size_t kUnknowns = 40;
  const auto times = [](std::span<const Spectrum> x, std::span<Spectrum> y) {
    for (std::size_t i = 0; i < kUnknowns; ++i)
      y[i] = x[i] - Spectrum{.1, .5, .95} * x[(i + 1) % kUnknowns] -
             Spectrum{.2, .1, .04} * x[(i + 7) % kUnknowns];
  };
  std::vector<Spectrum> answer(kUnknowns), b(kUnknowns);
  for (std::size_t i = 0; i < kUnknowns; ++i) answer[i] = {1.0 + double(i), double(i % 5), 1};
  times(answer, b);
  const std::vector<Spectrum> ones(kUnknowns, Spectrum{1});
  const std::vector<Spectrum> x = bicgstab(times, ones, b, 1e-12, 500);
  // Rows of the third channel sum to .01: what is left of its residual counts a hundred times.
  for (std::size_t i = 0; i < kUnknowns; ++i)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(x[i][c], answer[i][c], 1e-7) << i << ' ' << c;
}

TEST(Bicgstab, NothingOnTheRightIsNothingOnTheLeft) {
  const auto times = [](std::span<const Spectrum> x, std::span<Spectrum> y) {
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = 2.0 * x[i];
  };
  const std::vector<Spectrum> b{Spectrum{4, 0, 2}}, diagonal{Spectrum{2}};
  EXPECT_EQ(bicgstab(times, diagonal, b, 1e-9, 10)[0], (Spectrum{2, 0, 1}));
}

// Rows that grow leave holes, which are closed before they are more than what is alive.
TEST(CoarseMatrix, RowsThatAreReplacedOverAndOverStayWholeAndTakeNoMore) {
  constexpr std::uint32_t kUnits = 300;
  CoarseMatrix matrix(kUnits);
  std::size_t most = 0;
  for (std::uint32_t round = 1; round <= 64; ++round)
    for (std::uint32_t u = 0; u < kUnits; ++u) {
      std::vector<CoarseEntry> row(1 + (u + round * 37) % 200);
      for (std::uint32_t i = 0; i < row.size(); ++i) row[i].unit = u + round + i;
      matrix.set(u, row);
      most = std::max(most, matrix.bytes());
    }
  for (std::uint32_t u = 0; u < kUnits; ++u) {
    ASSERT_EQ(matrix[u].size(), 1 + (u + 64 * 37) % 200);
    for (std::uint32_t i = 0; i < matrix[u].size(); ++i) EXPECT_EQ(matrix[u][i].unit, u + 64 + i);
  }
  // Twice what may be alive, and three runs of 512 KiB: one of slack, one begun, one while closing.
  EXPECT_LT(most, 2 * kUnits * 200 * sizeof(CoarseEntry) + (std::size_t{3} << 19));
}

}  // namespace
}  // namespace atrium::testing
