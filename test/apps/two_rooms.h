// Two rooms and a gap between them, as a scene file.
#pragma once

#include <array>
#include <sstream>
#include <string>

namespace atrium::testing {

// Boxes as a modeller leaves them, in centimetres: two rooms of 4 × 4 × 3 m, 0.2 m of wall around
// them and between, and `gap` between that wall and the ceiling. No lamps.
inline std::string two_rooms_obj(double gap) {
  std::ostringstream obj;
  int vertices = 0;
  const auto box = [&](const std::string& name, std::array<double, 3> lo,
                       std::array<double, 3> hi) {
    obj << "o " << name << '\n';
    for (int i = 0; i < 8; ++i)
      obj << "v " << (i & 1 ? hi : lo)[0] << ' ' << (i & 2 ? hi : lo)[1] << ' '
          << (i & 4 ? hi : lo)[2] << '\n';
    for (const std::array<int, 4>& f : {std::array{1, 3, 4, 2},
                                        {5, 6, 8, 7},
                                        {1, 2, 6, 5},
                                        {3, 7, 8, 4},
                                        {1, 5, 7, 3},
                                        {2, 4, 8, 6}})
      obj << "f " << vertices + f[0] << ' ' << vertices + f[1] << ' ' << vertices + f[2] << ' '
          << vertices + f[3] << '\n';
    vertices += 8;
  };
  box("floor", {-20, -20, -20}, {840, 420, 0});
  box("ceiling", {-20, -20, 300}, {840, 420, 320});
  box("west", {-20, -20, 0}, {0, 420, 300});
  box("east", {820, -20, 0}, {840, 420, 300});
  box("south", {0, -20, 0}, {820, 0, 300});
  box("north", {0, 400, 0}, {820, 420, 300});
  box("partition", {400, 0, 0}, {420, 400, 300 - gap});
  return obj.str();
}

}  // namespace atrium::testing
