// Warnings gathered during import: counted by what they say, with the first few examples named.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/scene.h"

namespace atrium {

class WarningLog {
 public:
  static constexpr std::size_t kExamples = 8;

  void add(const std::string& what, const std::string& example, std::uint64_t count = 1) {
    Warning& w = entry(what);
    w.count += count;
    if (w.examples.size() < kExamples &&
        std::find(w.examples.begin(), w.examples.end(), example) == w.examples.end())
      w.examples.push_back(example);
  }
  std::vector<Warning> take() { return std::move(warnings_); }

 private:
  Warning& entry(const std::string& what) {
    for (Warning& w : warnings_)
      if (w.what == what) return w;
    return warnings_.emplace_back(Warning{what, 0, {}});
  }
  std::vector<Warning> warnings_;  // in order of first appearance
};

}  // namespace atrium
