// The regular expressions of --drop (ECMAScript), searched for in names.
#pragma once

#include <memory>
#include <string>

#include "engine/status.h"

namespace atrium {

class NamePattern {
 public:
  static Result<NamePattern> compile(const std::string& text);
  bool found_in(const std::string& name) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace atrium
