// Validation: what a suite of `atrium validate` found, a case at a time.
//
// Invariant: what is not a number never passes; `within` and `at_most` see to it.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace atrium {

struct ValidationCase {
  std::string name;
  double expected = 0, found = 0;
  double allowed = 0;  // how far off it may be and pass
  bool pass = false;
  double difference() const { return found - expected; }
};

// Passes where `found` is as far off as `allowed` or nearer.
inline ValidationCase within(std::string name, double expected, double found, double allowed) {
  return {std::move(name), expected, found, allowed, std::abs(found - expected) <= allowed};
}

// Passes where `found` is `bound` or less; the bound stands as what is expected.
inline ValidationCase at_most(std::string name, double bound, double found) {
  return {std::move(name), bound, found, 0, found <= bound};
}

struct Validation {
  std::string suite;
  std::vector<ValidationCase> cases;
  std::vector<std::pair<std::string, double>> figures;  // measured beside it, judged by nobody
  std::vector<std::string> examples;                    // of what failed, in words

  // A suite that judged nothing has shown nothing.
  bool pass() const {
    return !cases.empty() &&
           std::all_of(cases.begin(), cases.end(), [](const ValidationCase& c) { return c.pass; });
  }
};

}  // namespace atrium
