// IoClock: adds the time it lives, in seconds, to a total. Put around calls to the disk.
#pragma once

#include <chrono>

namespace atrium {

class [[nodiscard]] IoClock {
 public:
  explicit IoClock(double& seconds) : seconds_(seconds) {}
  ~IoClock() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  IoClock(const IoClock&) = delete;
  IoClock& operator=(const IoClock&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace atrium
