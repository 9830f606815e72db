// Validation: what a suite of `atrium validate` found, a case at a time.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace atrium {

struct ValidationCase {
  std::string name;
  double expected = 0, found = 0;
  bool pass = false;
  double difference() const { return found - expected; }
};

struct Validation {
  std::string suite;
  std::vector<ValidationCase> cases;
  std::vector<std::pair<std::string, double>> figures;  // measured beside it, judged by nobody
  std::vector<std::string> examples;                    // of what failed, in words

  bool pass() const {
    return std::all_of(cases.begin(), cases.end(), [](const ValidationCase& c) { return c.pass; });
  }
};

}  // namespace atrium
