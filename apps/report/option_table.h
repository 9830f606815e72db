// The options of runs, as people write them, and which of them tell runs apart.
#pragma once

#include <string>
#include <vector>

#include "apps/report/run_data.h"

namespace atrium {

struct OptionRow {
  std::string key;
  std::vector<std::string> values;  // a run each; empty: not set
  bool differs = false;             // between runs
};

// "512 MiB", "5%"; of files the names, without folders.
std::string option_text(const Setting& setting);

// Those that differ between runs, or from their default; not the scene, not the version.
std::vector<OptionRow> telling_options(const std::vector<const RunData*>& runs);

}  // namespace atrium
