#include "bench/paper_report/tables.h"

#include <gtest/gtest.h>

#include "test/bench/runs.h"

namespace atrium::testing {
namespace {

std::vector<std::string> first_words(const TextTable& table) {
  std::vector<std::string> found;
  for (const auto& row : table.rows) {
    EXPECT_EQ(row.size(), table.columns.size());
    found.push_back(row[0].words + " " + row[1].words);
  }
  return found;
}

using Words = std::vector<std::string>;

TEST(ModelsTable, HasOursUnderThePapersForEachModelThatWasSolved) {
  SolvedModel office, floor;
  office.figures.model = "Office";
  floor.figures.model = "Floor";
  const Words names{"Office", "Floor", "Building"};
  const std::vector<SolvedModel> ours{floor, office};
  EXPECT_EQ(first_words(models_table(names, ours)),
            (Words{"Office paper", "Office ours", "Floor paper", "Floor ours"}));
}

TEST(OrdersTable, HasThePapersOrdersFirst) {
  OrderFigures cell, hilbert;
  cell.order = "cell";
  hilbert.order = "hilbert";
  EXPECT_EQ(first_words(orders_table(std::vector{hilbert, cell})),
            (Words{"cell paper", "cell ours", "hilbert ours"}));
}

TEST(IterationsTable, PutsIterationsOfANumberTogether) {
  const TextTable table = iterations_table(iteration_figures({}, two_iterations()));
  ASSERT_EQ(table.rows.size(), 8u);
  const std::string text = markdown(table);
  EXPECT_NE(text.find("| 1 | paper | 295,039 | 2,649,521 | 2.0 | 3.3 h | 0.2 h | 5.1 h |\n"
                      "| 1 | ours | 100 | 1,000 | 7.0 | 1.50 s | 0.50 s | 3.00 s |\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("| Total | ours | 200 | 2,000 | 7.0 | 3.00 s | 1.00 s | 6.00 s |\n"),
            std::string::npos)
      << text;
}

TEST(ResultsTable, HasARowAModel) {
  SolvedModel office;
  office.figures.model = "Office";
  office.figures.patches = 127;
  office.run = two_iterations();
  office.run.history.back().cpu_seconds = 9;
  const std::vector<SolvedModel> ours{office};
  EXPECT_NE(markdown(results_table(ours)).find("| Office | – / 127 / – | "), std::string::npos);
}

}  // namespace
}  // namespace atrium::testing
