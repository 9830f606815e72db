// Data to where it was asked for: stdout, or a file that stands whole or not at all.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "engine/status.h"

namespace atrium {

// Writes the parts one behind the other. path: empty or "-" is stdout. A file is written beside its
// place and moved there when it is whole, so that what stood there stays until then.
Status write_output(const std::string& path, std::initializer_list<std::string_view> parts);

// The whole of a file, or of stdin for "-". Errors: kUsage.
Result<std::string> read_input(const std::string& path);

}  // namespace atrium
