#include "apps/report/interaction_matrix.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace atrium::testing {
namespace {

constexpr double kExact = 1e-12;

std::vector<ClusterId> order_of(const std::vector<std::size_t>& clusters) {
  std::vector<ClusterId> order;
  for (const std::size_t c : clusters) order.push_back(ClusterId(c));
  return order;
}

// Clusters along a corridor, each of which sees itself and so many neighbours on either side.
Rows<ClusterId> corridor(std::size_t clusters, std::size_t reach) {
  Rows<ClusterId> visible;
  for (std::size_t c = 0; c < clusters; ++c) {
    std::vector<ClusterId> row;
    for (std::size_t s = 0; s < clusters; ++s)
      if (std::max(c, s) - std::min(c, s) <= reach) row.push_back(ClusterId(s));
    visible.push_row(row);
  }
  return visible;
}

TEST(InteractionMatrix, ACorridorInItsOrderIsABand) {
  const InteractionMatrix m = interaction_matrix(corridor(4, 1), order_of({0, 1, 2, 3}));
  EXPECT_EQ(m.side, 4u);
  EXPECT_EQ(m.share, (std::vector<double>{1, 1, 0, 0,  //
                                          1, 1, 1, 0,  //
                                          0, 1, 1, 1,  //
                                          0, 0, 1, 1}));
  EXPECT_EQ(m.pairs, 10u) << "four of themselves, and three neighbours both ways";
  // The second, third and fourth gather see 3, 3 and 2; of those the one before sees 2 each.
  EXPECT_NEAR(m.common, 6.0 / 8, kExact);
}

TEST(InteractionMatrix, RowsAndColumnsAreInTheOrderOfTheGathers) {
  Rows<ClusterId> visible;  // 2 sees 0, and 0 sees 2
  visible.push_row(std::vector{ClusterId(std::size_t{2})});
  visible.push_row({});
  visible.push_row(std::vector{ClusterId(std::size_t{0})});
  const InteractionMatrix m = interaction_matrix(visible, order_of({2, 0, 1}));
  EXPECT_EQ(m.share, (std::vector<double>{0, 1, 0,  //
                                          1, 0, 0,  //
                                          0, 0, 0}));
  EXPECT_EQ(m.common, 0) << "0 sees 2 alone, 2 sees 0";
}

// Ten clusters in three cells are 4, 3 and 3: a cell's share is of its own pairs.
TEST(InteractionMatrix, CellsOfUnequalSizeAreShadedByTheirOwnPairs) {
  std::vector<std::size_t> all(10);
  for (std::size_t c = 0; c < all.size(); ++c) all[c] = c;
  const InteractionMatrix whole = interaction_matrix(corridor(10, 9), order_of(all), 3);
  EXPECT_EQ(whole.side, 3u);
  for (const double share : whole.share) EXPECT_NEAR(share, 1, kExact);
  const InteractionMatrix selves = interaction_matrix(corridor(10, 0), order_of(all), 3);
  EXPECT_NEAR(selves.share[0], 1.0 / 4, kExact);
  EXPECT_NEAR(selves.share[4], 1.0 / 3, kExact);
  EXPECT_NEAR(selves.share[8], 1.0 / 3, kExact);
}

TEST(InteractionMatrix, ItsSizeIsBoundedWhateverTheScene) {
  std::vector<std::size_t> all(kMostMatrixCells * 3 + 1);
  for (std::size_t c = 0; c < all.size(); ++c) all[c] = c;
  EXPECT_EQ(interaction_matrix(corridor(all.size(), 1), order_of(all)).side, kMostMatrixCells);
}

TEST(MatrixImage, TheFirstPairIsAtTheLowerLeftAndMorePairsAreDarker) {
  InteractionMatrix m;
  m.side = 2;
  m.share = {1, 0,  //
             .25, 0};
  const Image image = matrix_image(m);
  EXPECT_EQ(image.at(0, 1)[0], 0) << "all of them: black";
  EXPECT_EQ(image.at(1, 0)[0], 1) << "none: white";
  EXPECT_GT(image.at(0, 0)[0], 0);
  EXPECT_LT(image.at(0, 0)[0], 1);
}

}  // namespace
}  // namespace atrium::testing
