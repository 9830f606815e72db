// Models of scenes built by hand, and what is asked of them by objects' names.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "visibility/partition.h"

namespace atrium {

inline Model made(const Scene& scene, double close_gaps = 0) {
  PartitionOptions options;
  options.close_gaps = close_gaps;
  Result<Model> model = partition(scene, options);
  EXPECT_TRUE(model.ok()) << model.status().message();
  return std::move(model).value();
}

inline const std::string& name_of(const Scene& scene, const Surface& surface) {
  return scene.objects[surface.object.value].name;
}

inline const std::string& name_of(const Scene& scene, const Cluster& cluster) {
  return scene.objects[cluster.object.value].name;
}

// The object's first one.
inline ClusterId cluster_of(const Model& model, const Scene& scene, const std::string& object) {
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c)
    if (name_of(scene, model.clusters[c]) == object) return ClusterId(c);
  ADD_FAILURE() << "no " << object;
  return {};
}

inline bool listed(const Model& model, ClusterId a, ClusterId b) {
  const auto row = model.visible[a.value];
  return std::binary_search(row.begin(), row.end(), b);
}

}  // namespace atrium
