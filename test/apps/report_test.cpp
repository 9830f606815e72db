#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "test/apps/program.h"
#include "test/apps/well_formed.h"

namespace atrium::testing {
namespace {

using Json = nlohmann::json;

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// Words of a piece of the page, its tags and drawings taken out.
std::string words_of(const std::string& html) {
  static const std::regex kDrawing("<svg[^]*?</svg>"), kTag("<[^>]*>"), kBlanks("\\s+");
  const std::string plain = std::regex_replace(std::regex_replace(html, kDrawing, " "), kTag, " ");
  return std::regex_replace(plain, kBlanks, " ");
}

// The words of the page's section with this heading.
std::string section(const std::string& page, const std::string& heading) {
  const std::size_t begin = page.find("<h2>" + heading);
  if (begin == std::string::npos) return "";
  return words_of(page.substr(begin, page.find("<h2>", begin + 1) - begin));
}

std::size_t charts(const std::string& page) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = page.find("<svg class=\"chart\"", at)) != std::string::npos; ++at)
    ++count;
  return count;
}

std::string entry(int iteration, int gathered, double seconds, double residual, int rays,
                  Json more = Json::object()) {
  Json j{{"seconds", seconds},
         {"cpu_seconds", 2 * seconds},
         {"iteration", iteration},
         {"residual", residual},
         {"clusters_gathered", gathered},
         {"elements", 1000 * iteration},
         {"links", 5000 * iteration},
         {"rays", rays},
         {"hit_ratio", 0.5},
         {"max_working_set_bytes", 2e6},
         {"peak_rss_bytes", 150e6}};
  j.update(more);
  return j.dump() + "\n";
}

// Two runs of two iterations: `fine` knows its true error, and stopped once within iteration 1;
// `coarse` has an estimate alone.
class Report : public ::testing::Test {
 protected:
  Report() {
    write("fine", "run.toml",
          "version = \"atrium 0.1.0\"\nscene = [\"/s/room.obj\"]\n"
          "error = 0.02\nbasis = 2\n");
    write("fine", "history.jsonl",
          entry(1, 3, 1, 0.9, 60) + entry(1, 4, 2, 0.5, 100, {{"error_true", 0.1}}) +
              entry(2, 4, 8, 0.1, 50, {{"error_true", 0.016}}));
    write("fine", "summary.json",
          Json{{"clusters", 4},
               {"iterations", 2},
               {"elements", 2000},
               {"links", 10000},
               {"total_seconds", 8.5},
               {"error_true", 0.016},
               {"hit_ratio", 0.5},
               {"flux_emitted", 200},
               {"flux_absorbed", 150},
               {"flux_escaped", 40},
               {"energy_closure", -0.013},
               {"stop_reason", "converged"},
               {"exit_code", 0},
               {"peak_rss_bytes", 160e6},
               {"left_out", {{{"feature", "eviction"}, {"why", "all fits"}}}}}
              .dump());
    write("coarse", "run.toml",
          "version = \"atrium 0.1.0\"\nscene = [\"/s/room.obj\"]\n"
          "error = 0.05\nbasis = 2\n");
    write("coarse", "history.jsonl",
          entry(1, 4, 1, 0.5, 10, {{"error_estimate", 0.2}}) +
              entry(2, 4, 4, 0.2, 5,
                    {{"error_estimate", 0.04},
                     {"error_estimate_low", 0.03},
                     {"error_estimate_high", 0.05}}));
    write("coarse", "summary.json",
          Json{{"clusters", 4},
               {"iterations", 2},
               {"elements", 2000},
               {"links", 10000},
               {"total_seconds", 4.25},
               {"error_estimate", 0.04},
               {"error_estimate_low", 0.03},
               {"error_estimate_high", 0.05},
               {"hit_ratio", 0.5},
               {"stop_reason", "iterations"},
               {"exit_code", 5}}
              .dump());
  }

  void write(const std::string& run, const std::string& name, const std::string& text) {
    std::filesystem::create_directories(folder_ / run);
    write_file(folder_ / (run + "/" + name), text);
  }
  std::string page_of(const std::vector<std::string>& runs) {
    std::vector<std::string> words{"report"};
    for (const std::string& r : runs) words.push_back(folder_ / r);
    const Ended e = run(words);
    EXPECT_EQ(e.code, 0) << e.err;
    return e.out;
  }

  Folder folder_;
};

TEST_F(Report, TwoRunsStandSideBySide) {
  const std::string page = page_of({"fine", "coarse"});
  EXPECT_EQ(fault_of(page.substr(0, page.find("<style>")) + page.substr(page.find("</style>") + 8)),
            "");
  EXPECT_EQ(charts(page), 6u);
  EXPECT_TRUE(has(words_of(page), "room.obj: 2 runs"));
  const std::string figures = section(page, "The runs in figures");
  // asked, estimate, true, estimate ÷ true, elements, links, rays 100 + 50, iterations, wall,
  // CPU 2 x 8, peak, hits, and 2000 elements at 1.6%.
  EXPECT_TRUE(
      has(figures, " fine 2.00% – 1.60% – 2,000 10,000 150 2 8.50 16.00 160.0 50.00% 1,250 "))
      << figures;
  // 10 + 5 rays; 2000 elements at an estimate of 4%.
  EXPECT_TRUE(has(figures,
                  " coarse 5.00% 4.00% 3.00% to 5.00% – – 2,000 10,000 15 2 4.25 8.00 150.0 "
                  "50.00% 500 "))
      << figures;
}

TEST_F(Report, OptionsThatDifferAreMarked) {
  const std::string page = page_of({"fine", "coarse"});
  EXPECT_TRUE(has(page, "<td class=\"marked\">2%</td><td class=\"marked\">5%</td>"));
  EXPECT_FALSE(has(page, "<th>basis</th>")) << "at its default in both";
}

TEST_F(Report, WhatIsEmittedIsAbsorbedEscapesOrIsTold) {
  const std::string balance = section(page_of({"fine", "coarse"}), "Energy balance");
  EXPECT_TRUE(has(balance, " fine 200 150 75.00% 40 20.00% 10 5.00% −1.30% ")) << balance;
  EXPECT_TRUE(has(balance, "coarse: no summary that tells what was emitted")) << balance;
}

TEST_F(Report, WhatIsNotThereIsSaid) {
  const std::string errors = section(page_of({"fine", "coarse"}), "Error against run time");
  EXPECT_TRUE(has(errors, "fine: no error estimate in the history.")) << errors;
  EXPECT_TRUE(has(errors, "coarse: no true error, for no reference was given.")) << errors;
}

TEST_F(Report, ARunThatHasJustBegunHasSentencesAndNoEmptyFigures) {
  write("begun", "run.toml", "version = \"atrium 0.1.0\"\nscene = [\"/s/room.obj\"]\n");
  const std::string page = page_of({"begun"});
  EXPECT_EQ(charts(page), 0u);
  EXPECT_TRUE(has(words_of(page), "interrupted"));
  EXPECT_TRUE(has(section(page, "Error against run time"), "no error to hold against time"));
  EXPECT_TRUE(has(section(page, "Iterations"), "no complete iteration yet"));
  EXPECT_TRUE(has(section(page, "The runs in figures"), "no summary yet"));
  EXPECT_TRUE(has(section(page, "Energy balance"), "no summary"));
  EXPECT_TRUE(has(section(page, "Working set and memory") + section(page, "Input and output"),
                  "no summary"));
  EXPECT_TRUE(has(section(page, "What was left out"), "No summary"));
  EXPECT_TRUE(has(section(page, "History"), "no history yet"));
}

TEST_F(Report, ANullResidualLeavesTheOtherFigures) {
  write("fine", "history.jsonl",
        "{\"seconds\":1,\"iteration\":1,\"residual\":null,\"elements\":7}\n");
  const std::string page = page_of({"fine"});
  EXPECT_EQ(charts(page), 1u) << "elements alone";
  EXPECT_TRUE(has(section(page, "Iterations"), "nothing to draw"));
}

TEST_F(Report, AnIterationThatIsNotCompleteIsNoPointOfTheFiguresByIteration) {
  write("fine", "history.jsonl",
        entry(1, 4, 2, 0.5, 1) + entry(2, 4, 3, 0.25, 1) + entry(3, 1, 4, 0.001, 1));
  const std::string page = page_of({"fine"});
  EXPECT_TRUE(has(section(page, "Iterations"), "fine: iteration 3 is not complete")) << page;
  EXPECT_TRUE(has(page, "<title>fine: iteration 2, 0.25</title>"));
  EXPECT_FALSE(has(page, "<title>fine: iteration 3,"));
}

// The third iteration is under way, and its few elements are no figure of the run.
TEST_F(Report, ARunThatIsNotOverHasTheFiguresOfItsLastCompleteIteration) {
  std::filesystem::remove(folder_ / "fine/summary.json");
  write("fine", "history.jsonl",
        entry(1, 4, 2, 0.5, 1, {{"error_true", 0.1}}) +
            entry(2, 4, 3, 0.25, 1, {{"error_true", 0.05}}) +
            entry(3, 1, 4, 0.001, 1, {{"elements", 9}}));
  const std::string figures = section(page_of({"fine"}), "The runs in figures");
  // CPU 2 x 4 s, and 2000 elements at 5%.
  EXPECT_TRUE(has(figures, " fine 2.00% – 5.00% – 2,000 10,000 3 2 3.00 8.00 150.0 50.00% 400 "))
      << figures;
}

TEST_F(Report, NamesAreTextWhateverTheyHold) {
  const std::string name = "a <b> & \"c\" 'd'";
  write(name, "run.toml", "scene = [\"/s/<script>.obj\"]\n");
  write(name, "history.jsonl", entry(1, 4, 1, 0.5, 1, {{"error_true", 0.1}}));
  write(name, "summary.json",
        Json{{"stop_reason", "</td><script>"}, {"left_out", {{{"feature", "<i>"}, {"why", "&"}}}}}
            .dump());
  const std::string page = page_of({name, "fine"});
  EXPECT_FALSE(has(page, "<script"));
  EXPECT_FALSE(has(page, "<b>"));
  EXPECT_FALSE(has(page, "<i>"));
  EXPECT_TRUE(has(page, "a &lt;b&gt; &amp; &quot;c&quot; &#39;d&#39;"));
  EXPECT_EQ(fault_of(page.substr(page.find("<body>"), page.find("</html>") - page.find("<body>"))),
            "");
}

TEST_F(Report, ThePageFetchesNothingAndEqualRunsGiveEqualBytes) {
  const std::string page = page_of({"fine", "coarse"});
  for (const char* fetching : {"<script", "http:", "https:", "src=", "href=", "url(", "@import"})
    EXPECT_FALSE(has(page, fetching)) << fetching;
  EXPECT_EQ(page_of({"fine", "coarse"}), page);
}

TEST_F(Report, RunsThatAreCalledAlikeAreNamedInFull) {
  std::filesystem::create_directories(folder_ / "other");
  std::filesystem::copy(folder_ / "fine", folder_ / "other/fine");
  EXPECT_TRUE(has(page_of({"fine", "other/fine"}), (folder_ / "other/fine") + "</th>"));
}

TEST_F(Report, ABrokenHistoryIsAnErrorOfTheStore) {
  write("fine", "history.jsonl", entry(1, 4, 2, 0.5, 1) + "{]\n");
  const Ended e = run({"report", folder_ / "fine", "-o", folder_ / "page.html"});
  EXPECT_EQ(e.code, 4);
  EXPECT_TRUE(has(e.err, (folder_ / "fine/history.jsonl") + ": line 2: ")) << e.err;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "page.html"));
}

TEST_F(Report, WhatItCannotDoIsRefused) {
  EXPECT_EQ(run({"report"}).code, 2);
  EXPECT_EQ(run({"report", folder_ / "nowhere"}).code, 2);
  EXPECT_EQ(run({"report", folder_ / "fine", folder_ / "fine"}).code, 2);
  EXPECT_EQ(run({"report", folder_ / "fine", "--json"}).code, 2);
}

TEST_F(Report, JsonTellsOfThePageThatWasWritten) {
  const std::string file = folder_ / "page.html";
  const Ended e = run({"report", folder_ / "fine", folder_ / "coarse", "-o", file, "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const Json told = Json::parse(e.out);
  EXPECT_EQ(told["file"], file);
  EXPECT_EQ(told["bytes"], read_file(file).size());
  EXPECT_EQ(told["runs"], (Json{"fine", "coarse"}));
}

TEST_F(Report, WithoutAPageStoreThereIsNoInteractionMatrix) {
  const std::string matrices = section(page_of({"fine", "coarse"}), "Interaction matrix");
  EXPECT_TRUE(has(matrices, "fine: no interaction matrix, ")) << matrices;
  EXPECT_TRUE(has(matrices, "coarse: no interaction matrix, ")) << matrices;
}

// The cube's six walls see each other and none itself, 30 of 36 pairs; of the five that one sees,
// the one before sees four.
TEST(ReportOfASolve, HoldsItsInteractionMatrix) {
  const Ended e = run({"report", furnace_run()});
  ASSERT_EQ(e.code, 0) << e.err;
  const std::string words = section(e.out, "Interaction matrix");
  EXPECT_TRUE(has(words,
                  "run: cell order 6 clusters, 83.3% of their pairs may see each other; "
                  "of what a gather may see, the one before it saw 80%."))
      << words;
  EXPECT_TRUE(has(e.out, " src=\"data:image/png;base64,iVBORw0KGgo")) << "a PNG's first bytes";
  const std::size_t body = e.out.find("<body>");
  EXPECT_EQ(fault_of(e.out.substr(body, e.out.find("</html>") - body)), "");
}

TEST(ReportOfASolve, HasItsFigures) {
  const Ended e = run({"report", furnace_run()});
  ASSERT_EQ(e.code, 0) << e.err;
  EXPECT_GE(charts(e.out), 4u) << "all by iteration; of errors, what its history knows";
  EXPECT_TRUE(has(words_of(e.out), "cube.obj"));
  EXPECT_TRUE(has(section(e.out, "The runs in figures"), " 2.00% ")) << "asked by default";
}

}  // namespace
}  // namespace atrium::testing
