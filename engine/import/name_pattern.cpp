#include "engine/import/name_pattern.h"

// GCC 12 takes std::regex's own moves for uninitialized under the sanitizers.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <regex>

namespace atrium {

struct NamePattern::Compiled {
  std::regex regex;
};

Result<NamePattern> NamePattern::compile(const std::string& text) {
  try {
    NamePattern pattern;
    pattern.compiled_ = std::make_shared<Compiled>(Compiled{std::regex(text)});
    return pattern;
  } catch (const std::regex_error& e) {
    return Status(Code::kUsage, "", "", "--drop '" + text + "': " + e.what(),
                  "write an ECMAScript regular expression");
  }
}

bool NamePattern::found_in(const std::string& name) const {
  return std::regex_search(name, compiled_->regex);
}

}  // namespace atrium
