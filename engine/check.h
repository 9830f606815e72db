// CHECK: what cannot happen. Stays on in release: a wrong answer costs more than the test.
#pragma once

namespace atrium {

[[noreturn]] void check_failed(const char* file, int line, const char* condition);

}  // namespace atrium

#define ATRIUM_CHECK(condition)                                            \
  do {                                                                     \
    if (!(condition)) ::atrium::check_failed(__FILE__, __LINE__, #condition); \
  } while (false)
