#include <sstream>

#include "apps/command.h"
#include "scheduler/history.h"

namespace atrium {

std::string version_text() {
  std::ostringstream out;
  out << program_version() << "\nbuild: " << ATRIUM_BUILD << "\nlibraries: " << ATRIUM_LIBRARIES
      << '\n';
  return out.str();
}

}  // namespace atrium
