#include "bench/paper_report/text_table.h"

#include <gtest/gtest.h>

namespace atrium {
namespace {

TextTable table() {
  return {{{"Order", "order"}, {"MB Read", "read_mb"}, {"Time", "seconds"}},
          {{word_entry("cell"), number_entry(1234.56, 1), number_entry(5400, 1, 3600, " h")},
           {word_entry("random"), number_entry({}), number_entry(0.25, 0, .01, "%")}}};
}

TEST(TextTable, AsMarkdownNumbersAreRoundedInTheirUnit) {
  EXPECT_EQ(markdown(table()),
            "| Order | MB Read | Time |\n|---|---|---|\n"
            "| cell | 1,234.6 | 1.5 h |\n"
            "| random | – | 25% |\n");
}

TEST(TextTable, ARoundedNumberCarries) {
  EXPECT_EQ(markdown({{{"x", "x"}}, {{number_entry(999.96, 1)}}}), "| x |\n|---|\n| 1,000.0 |\n");
}

TEST(TextTable, AsCsvNumbersAreWholeAndWhatIsNotThereIsEmpty) {
  EXPECT_EQ(csv(table()), "order,read_mb,seconds\ncell,1234.56,5400\nrandom,,0.25\n");
}

}  // namespace
}  // namespace atrium
