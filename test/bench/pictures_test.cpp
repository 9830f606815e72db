#include "bench/paper_report/pictures.h"

#include <gtest/gtest.h>

#include "test/apps/well_formed.h"
#include "test/bench/runs.h"

namespace atrium::testing {
namespace {

// What comes behind the style, which is no markup.
std::string drawn(const std::string& svg) { return svg.substr(svg.find("</style>") + 8); }

bool well_formed(const std::string& svg) { return fault_of("<svg>" + drawn(svg)).empty(); }

TEST(WorkingSetPicture, IsALineOfTheLargestAndOneOfTheMean) {
  const std::string svg = working_set_picture("Building", *fullest_iteration(two_iterations()));
  EXPECT_TRUE(well_formed(svg)) << fault_of("<svg>" + drawn(svg));
  EXPECT_NE(svg.find(">largest<"), std::string::npos);
  EXPECT_NE(svg.find(">mean<"), std::string::npos);
}

TEST(MatricesPicture, HasAPanelForEachOrderUnderItsLetter) {
  InteractionMatrix m;
  m.clusters = m.side = 1;
  m.share = {1};
  const Result<std::string> svg = matrices_picture({{"random", m}, {"cell", m}});
  ASSERT_TRUE(svg.ok());
  EXPECT_TRUE(well_formed(*svg)) << fault_of("<svg>" + drawn(*svg));
  EXPECT_NE(svg->find("A) random order"), std::string::npos);
  EXPECT_NE(svg->find("B) cell order"), std::string::npos);
}

TEST(IoShare, IsThatOfTheWholeTime) {
  EXPECT_NEAR(*io_share(paper_orders().front()), .475, .0005) << "as the paper says";
  EXPECT_NEAR(*io_share(paper_orders().back()), .120, .0005);
  EXPECT_FALSE(io_share({}));
}

TEST(TimePicture, HasThePapersBarOverOurs) {
  OrderFigures cell, hilbert;
  cell.order = "cell";
  hilbert.order = "hilbert";
  cell.io_seconds = hilbert.io_seconds = 1;
  cell.seconds = hilbert.seconds = 4;
  const std::string svg = time_picture(std::vector{cell, hilbert});
  EXPECT_TRUE(well_formed(svg)) << fault_of("<svg>" + drawn(svg));
  const std::size_t paper = svg.find(">paper<"), ours = svg.find(">ours<");
  EXPECT_LT(paper, ours);
  EXPECT_EQ(svg.find(">paper<", paper + 1), std::string::npos) << "of hilbert it has none";
  EXPECT_NE(svg.find(">12%<"), std::string::npos) << "cell, the paper's";
  EXPECT_NE(svg.find(">25%<"), std::string::npos);
}

}  // namespace
}  // namespace atrium::testing
