// Time that passes, in seconds, by a clock that never goes back.
// now() is safe from any thread; a Stopwatch is immutable.
#pragma once

#include <chrono>

namespace atrium {

// Since a moment that stays the same while the process lives.
inline double now() {
  using namespace std::chrono;
  return duration<double>(steady_clock::now().time_since_epoch()).count();
}

class Stopwatch {
 public:
  double seconds() const { return now() - start_; }  // since it was made

 private:
  double start_ = now();
};

}  // namespace atrium
