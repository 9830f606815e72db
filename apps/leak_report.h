// Leaks for people and for other programs: a table, CSV. Places are in the scene's coordinates and
// units, sizes in metres.
#pragma once

#include <string>
#include <vector>

#include "engine/scene.h"
#include "visibility/leaks.h"

namespace atrium {

struct LeakRow {
  double width = 0, length = 0;      // m
  std::array<std::string, 2> rooms;  // "7", "outdoors"
  std::vector<std::string> objects;
  Vec3 at{0}, along{0};
};
std::vector<LeakRow> leak_rows(const Scene& scene, const std::vector<Leak>& leaks);

// `size`: what was looked for, m.
std::string leak_table(const std::vector<LeakRow>& leaks, std::uint32_t rooms, double size);
std::string leak_csv(const std::vector<LeakRow>& leaks);

}  // namespace atrium
