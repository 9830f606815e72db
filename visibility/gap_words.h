// Gaps and leaks in words, for reports: the objects around them by name and their places in the
// files' coordinates and units.
#pragma once

#include <string>
#include <vector>

#include "engine/model.h"
#include "engine/scene.h"

namespace atrium {

struct NamedGap {
  double width = 0, length = 0;      // m
  Vec3 at{0};                        // in the files' coordinates
  std::vector<std::string> objects;  // most of the rim first
};
std::vector<NamedGap> named_gaps(const Scene& scene, const std::vector<ClosedGap>& gaps);

// "3 mm x 2.5 m at 4.1 2 0: wall, floor"
std::string gap_words(const NamedGap& gap);

std::vector<std::string> names_of(const Scene& scene, const std::vector<ObjectId>& objects);

// The first few, and how many more there are.
std::string objects_words(const std::vector<std::string>& objects);

// "4.1 2 0", for people: place_words of segment_words.h is to the last bit.
std::string short_place(const Vec3& x);

}  // namespace atrium
