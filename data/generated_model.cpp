#include "data/generated_model.h"

namespace atrium {

ModelCounts GeneratedModel::counts() const {
  ModelCounts n{.clusters = groups.size(), .patches = faces.size()};
  for (const GeneratedFace& f : faces) n.lights += paints[f.paint].emits();
  return n;
}

}  // namespace atrium
