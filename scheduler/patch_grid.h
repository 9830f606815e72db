// What stands at a point: a uniform grid over the patches' boxes. The model outlives it; immutable.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "engine/model.h"

namespace atrium {

class PatchGrid {
 public:
  // margin: m, the largest tolerance that find() may be asked with.
  PatchGrid(const Model& model, const Box& bounds, double margin);

  double margin() const { return margin_; }

  // The patch side nearest to x within `tolerance` whose front the normal points away from; of two
  // as near, one that is not inert, then the first. None if there is none.
  std::optional<PatchId> find(const Vec3& x, const Vec3& normal, double tolerance) const;

 private:
  std::array<int, 3> at(const Vec3& x) const;
  std::size_t index(const std::array<int, 3>& i) const {
    return (std::size_t(i[2]) * size_[1] + i[1]) * size_[0] + i[0];
  }

  const Model* model_;
  Box box_;
  double margin_;
  double step_ = 1;
  std::array<int, 3> size_{1, 1, 1};
  Rows<PatchId> rows_;
};

}  // namespace atrium
