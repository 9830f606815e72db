// Segments in words, for reports: the objects they join and their ends in the files' coordinates.
#pragma once

#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"

namespace atrium {

// Of each kind of violation, the first so many are told.
inline constexpr std::size_t kMostExamples = 5;

// "(x y z)", in the files' coordinates and to the last bit.
std::string place_words(const Scene& scene, const Vec3& x);

// "from NAME (cluster 3) at (x y z) to NAME (cluster 7) at (x y z) ", of patches and points.
std::string segment_words(const Scene& scene, const Model& model, PatchId p, const Vec3& x,
                          PatchId q, const Vec3& y);

// Adds what words() says unless there are enough.
template <class Words>
void note(std::vector<std::string>& examples, Words&& words) {
  if (examples.size() < kMostExamples) examples.push_back(words());
}

}  // namespace atrium
