// atrium check RUN: verifies every page, record and text of a run.
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/report_json.h"
#include "engine/quantity.h"

namespace atrium {
namespace {

std::string check_text(const RunCheck& c, const std::string& run) {
  std::string text = run + ": ok\n  " + std::to_string(c.roots) + " roots, the newest of epoch " +
                     std::to_string(c.epoch) + "\n";
  for (const CheckedRecords& r : c.records)
    text +=
        "  " + r.kind + ": " + std::to_string(r.count) + " records, " + format_size(r.bytes) + "\n";
  text += "  " + format_size(c.summed_bytes) + " of texts match their sums";
  if (c.unsummed_bytes > 0)
    text += ", " + format_size(c.unsummed_bytes) + " came after the last checkpoint: unverified";
  if (!c.begun) text += "\n  nothing was begun yet";
  return text + "\n";
}

Result<int> run_check(const std::string& run, const Global& global) {
  const Result<RunCheck> checked = check_run(run);
  if (!checked.ok()) return checked.status();
  std::cout << (global.json ? check_json(*checked) : check_text(*checked, run));
  return 0;
}

}  // namespace

Command check_command() {
  auto words = std::make_shared<std::vector<std::string>>();
  Command command{"check", "verify every page, record and text of a run", {}, {}};
  command.options.argument("RUN", "a run directory", 1, 1, *words);
  command.run = [words](const Global& global, Console&) {
    return run_check(words->front(), global);
  };
  return command;
}

}  // namespace atrium
