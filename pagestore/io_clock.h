// IoClock: adds the time it lives, in seconds, to a total. Put around calls to the disk.
#pragma once

#include "engine/stopwatch.h"

namespace atrium {

class [[nodiscard]] IoClock {
 public:
  explicit IoClock(double& seconds) : seconds_(seconds) {}
  ~IoClock() { seconds_ += watch_.seconds(); }
  IoClock(const IoClock&) = delete;
  IoClock& operator=(const IoClock&) = delete;

 private:
  double& seconds_;
  Stopwatch watch_;
};

}  // namespace atrium
