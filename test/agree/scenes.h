// The small scenes that two methods are run on.
#pragma once

#include <string>

#include "test/agree/run.h"

namespace atrium::testing {

inline GeneratedModel cornell_model() { return generated({.kind = "cornell"}); }

// Two rooms of 4 m × 3 m × 2.7 m and a doorway; the first one's ceiling shines, the second one's
// walls are red.
inline GeneratedModel two_rooms_model() {
  GeneratedModel m = generated({.kind = "furnace", .rho = .6, .exitance = 1, .shape = "two-rooms"});
  m.paints = {{"grey", Spectrum{.6}, Spectrum{0}},
              {"lamp", Spectrum{.6}, Spectrum{100}},
              {"red", Spectrum{.7, .2, .1}, Spectrum{0}}};
  for (const GeneratedGroup& g : m.groups)
    for (std::uint32_t f = g.first_face; f < g.first_face + g.face_count; ++f) {
      const bool second = g.name.starts_with("room1_2/");
      const bool ceiling = g.name.find("ceiling") != std::string::npos;
      const bool wall = g.name.find("wall") != std::string::npos;
      m.faces[f].paint = !second && ceiling ? 1 : second && wall ? 2 : 0;
    }
  return m;
}

}  // namespace atrium::testing
