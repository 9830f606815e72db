// atrium report RUN... -o report.html: one self-contained page, one or several runs side by side.
#include <algorithm>
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/report/page.h"
#include "apps/report_json.h"

namespace atrium {
namespace {

constexpr std::size_t kMostRuns = 64;

struct Report {
  std::vector<std::string> runs;
  std::string output;
};

Status refuse_twice(const std::vector<RunData>& runs) {
  std::vector<std::string> names = names_of(runs);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice == names.end()) return {};
  return usage_error("the run '" + *twice + "' is named twice", "name each run once");
}

Result<int> run_report(const Report& report, const Global& global, Console& console) {
  if (global.json && (report.output.empty() || report.output == "-"))
    return usage_error("--json and the page cannot both go to stdout", "name its file by -o FILE");
  std::vector<RunData> runs;
  for (const std::string& directory : report.runs) {
    Result<RunData> run = read_run(directory);
    if (!run.ok()) return run.status();
    runs.push_back(std::move(*run));
  }
  ATRIUM_RETURN_IF_ERROR(refuse_twice(runs));
  std::vector<RunInteractions> interactions;
  for (const RunData& run : runs) interactions.push_back(read_interactions(run.directory));
  const std::string page = report_page(runs, interactions);
  ATRIUM_RETURN_IF_ERROR(write_output(report.output, {page}));
  if (global.json) std::cout << page_json(report.output, page.size(), names_of(runs));
  if (!report.output.empty())
    console.say(report.output + ": " + std::to_string(runs.size()) +
                (runs.size() == 1 ? " run" : " runs"));
  return 0;
}

}  // namespace

Command report_command() {
  auto report = std::make_shared<Report>();
  Command command{"report", "one page of one or several runs: error against run time", {}, {}};
  command.options.argument("RUN", "run directories, side by side", 1, kMostRuns, report->runs);
  command.options.output("the page to write, .html (stdout)", report->output);
  command.run = [report](const Global& global, Console& console) {
    return run_report(*report, global, console);
  };
  return command;
}

}  // namespace atrium
