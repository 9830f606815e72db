#include <sstream>

#include "apps/command.h"

namespace atrium {

std::string version_text() {
  std::ostringstream out;
  out << "atrium " << ATRIUM_VERSION << "\nbuild: " << ATRIUM_BUILD
      << "\nlibraries: " << ATRIUM_LIBRARIES << '\n';
  return out.str();
}

}  // namespace atrium
