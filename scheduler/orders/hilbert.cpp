// Hilbert order follows a Hilbert curve in space through the clusters' centres: what is near on the
// curve is near in space, though not the other way round.
#include <algorithm>
#include <array>
#include <utility>

#include "scheduler/orders/orders.h"

namespace atrium {

namespace {

constexpr int kBits = 21;  // an axis: three of them fill 63
using Coordinates = std::array<std::uint32_t, 3>;

// From coordinates to the transposed bits of the place on the curve. [Skilling, "Programming the
// Hilbert curve", 2004]
void to_transposed(Coordinates& x) {
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1) {
    const std::uint32_t below = q - 1;
    for (std::uint32_t& axis : x) {
      if (axis & q) {
        x[0] ^= below;
      } else {
        const std::uint32_t t = (x[0] ^ axis) & below;
        x[0] ^= t;
        axis ^= t;
      }
    }
  }
  x[1] ^= x[0];
  x[2] ^= x[1];
  std::uint32_t t = 0;
  for (std::uint32_t q = 1u << (kBits - 1); q > 1; q >>= 1)
    if (x[2] & q) t ^= q - 1;
  for (std::uint32_t& axis : x) axis ^= t;
}

std::uint64_t place_on_curve(Coordinates x) {
  to_transposed(x);
  std::uint64_t place = 0;
  for (int bit = kBits; bit-- > 0;)
    for (const std::uint32_t axis : x) place = place << 1 | (axis >> bit & 1);
  return place;
}

}  // namespace

Sequence hilbert_order(const OrderTask& task) {
  Box box;
  for (const Cluster& c : task.model.clusters) box.extend(c.bounds.center());
  const Vec3 extent = box.extent();
  const double side = std::max({extent.x, extent.y, extent.z, task.model.tolerance});
  constexpr double kLast = (1u << kBits) - 1;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> places;
  for (std::uint32_t c = 0; c < task.model.clusters.size(); ++c) {
    const Vec3 at = task.model.clusters[c].bounds.center() - box.lo;
    Coordinates x;
    for (int axis = 0; axis < 3; ++axis)
      x[std::size_t(axis)] = side > 0 ? std::uint32_t(at[axis] / side * kLast) : 0;
    places.push_back({place_on_curve(x), c});
  }
  std::sort(places.begin(), places.end());
  Sequence s;
  for (const auto& [place, c] : places) s.push_back(ClusterId(c));
  return s;
}

}  // namespace atrium
