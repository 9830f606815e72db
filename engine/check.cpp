#include "engine/check.h"

#include <cstdio>
#include <cstdlib>

namespace atrium {

void check_failed(const char* file, int line, const char* condition) {
  std::fprintf(stderr, "atrium: internal failure at %s:%d: %s does not hold\n", file, line,
               condition);
  std::abort();
}

}  // namespace atrium
