// Welding: points nearer than a distance become one, the first of them.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engine/vec.h"

namespace atrium {

class Welder {
 public:
  explicit Welder(double distance) : distance_(distance) {}
  // The number of the first point within the distance of x, or of x itself, now added.
  std::uint32_t weld(const Vec3& x);
  std::vector<Vec3> take() { return std::move(points_); }

 private:
  struct Hash {
    std::size_t operator()(const std::array<std::int64_t, 3>& c) const noexcept;
  };
  const double distance_;
  std::vector<Vec3> points_;
  std::vector<std::uint32_t> next_;  // of the points of one grid cube, a chain
  std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t, Hash> first_;
};

}  // namespace atrium
