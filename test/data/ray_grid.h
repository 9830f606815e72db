// First hits among a model's faces, found by walking a uniform grid: slow, plain, and independent
// of the engine's own ray structures.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "data/generated_model.h"

namespace atrium {

struct RayHit {
  std::size_t face = 0;
  double distance = 0;
  bool front = false;  // the ray meets the face's front
};

class RayGrid {
 public:
  explicit RayGrid(const GeneratedModel& model) : model_(model) {
    for (const Vec3& v : model.vertices) bounds_.extend(v);
    bounds_.lo -= kMargin;
    bounds_.hi += kMargin;
    const Vec3 extent = bounds_.extent();
    const double cells = std::clamp(2.0 * static_cast<double>(model.faces.size()), 64.0, 4e6);
    edge_ = std::cbrt(extent.x * extent.y * extent.z / cells);
    for (int k = 0; k < 3; ++k) size_[k] = static_cast<int>(extent[k] / edge_) + 1;
    cells_.resize(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) *
                  static_cast<std::size_t>(size_[2]));
    for (std::size_t f = 0; f < model.faces.size(); ++f) insert(f);
  }

  // The first face after `from` (left out: the face `origin_face` itself).
  std::optional<RayHit> first_hit(const Vec3& from, const Vec3& direction,
                                  std::size_t origin_face) const {
    int cell[3], step[3];
    double next[3], delta[3];
    for (int k = 0; k < 3; ++k) {
      cell[k] = cell_of(from[k], k);
      step[k] = direction[k] >= 0 ? 1 : -1;
      const double border = bounds_.lo[k] + edge_ * (cell[k] + (direction[k] >= 0 ? 1 : 0));
      next[k] = direction[k] == 0 ? kFar : (border - from[k]) / direction[k];
      delta[k] = direction[k] == 0 ? kFar : edge_ / std::abs(direction[k]);
    }
    while (true) {
      const int k = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
      std::optional<RayHit> best;
      for (std::uint32_t f : cells_[index(cell)]) {
        if (f == origin_face) continue;
        const auto hit = meet(f, from, direction);
        if (hit && (!best || hit->distance < best->distance)) best = hit;
      }
      if (best && best->distance <= next[k] + kMargin) return best;
      cell[k] += step[k];
      if (cell[k] < 0 || cell[k] >= size_[k]) return best;
      next[k] += delta[k];
    }
  }

 private:
  static constexpr double kMargin = 1e-3;  // m, around the model and the cells' borders
  static constexpr double kInside = 1e-9;  // m, by which faces reach over their edges
  static constexpr double kFar = 1e300;

  int cell_of(double x, int k) const {
    return std::clamp(static_cast<int>((x - bounds_.lo[k]) / edge_), 0, size_[k] - 1);
  }
  std::size_t index(const int* c) const {
    return (static_cast<std::size_t>(c[2]) * static_cast<std::size_t>(size_[1]) +
            static_cast<std::size_t>(c[1])) *
               static_cast<std::size_t>(size_[0]) +
           static_cast<std::size_t>(c[0]);
  }
  void insert(std::size_t f) {
    const Box box = bounds(model_.polygon(model_.faces[f]));
    int lo[3], hi[3], c[3];
    for (int k = 0; k < 3; ++k) {
      lo[k] = cell_of(box.lo[k] - kMargin, k);
      hi[k] = cell_of(box.hi[k] + kMargin, k);
    }
    for (c[2] = lo[2]; c[2] <= hi[2]; ++c[2])
      for (c[1] = lo[1]; c[1] <= hi[1]; ++c[1])
        for (c[0] = lo[0]; c[0] <= hi[0]; ++c[0])
          cells_[index(c)].push_back(static_cast<std::uint32_t>(f));
  }
  std::optional<RayHit> meet(std::size_t f, const Vec3& from, const Vec3& direction) const {
    const PolygonView polygon = model_.polygon(model_.faces[f]);
    const Vec3 normal = normalize(area_vector(polygon));
    const double slope = dot(normal, direction);
    if (slope == 0) return {};
    const double t = dot(normal, polygon[0] - from) / slope;
    if (!(t > 0) || !contains(polygon, normal, from + t * direction, kInside)) return {};
    return RayHit{f, t, slope < 0};
  }

  const GeneratedModel& model_;
  Box bounds_;
  double edge_ = 0;
  int size_[3] = {0, 0, 0};
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace atrium
