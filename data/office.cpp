#include "data/office.h"

#include "data/fittings.h"

namespace atrium::generator {
namespace {

constexpr int kWidth = 6000, kDepth = 4500, kHeight = 2800;  // mm
constexpr double kLampLuminance = 4000;                      // cd/m²: some 500 lx on the desks
constexpr int kWorkstations = 3;
constexpr double kFromWall = .04;  // m, desks and bookcases

// Table 2's patches, of which the books make up what the other furniture leaves.
int paper_patches(Furnish furnish) { return furnish == Furnish::kHigh ? 3466 : 1418; }

Plan office_plan(const Palette& p) {
  Plan plan;
  const int office =
      plan.add(Room{.name = "office",
                    .area = {0, kWidth, 0, kDepth},
                    .z1 = kHeight,
                    .finish = {p.carpet, p.ceiling, p.wall, p.base, kBaseHeight},
                    .ceiling_panels = {{1200, 1800, 1950, 2550}, {4200, 4800, 1950, 2550}},
                    .ceiling_panel = p.grille});
  plan.add(window(p, "window1", office, Side::kNorth, 900, 2500, 0));
  plan.add(window(p, "window2", office, Side::kNorth, 3500, 5100, 0));
  plan.add(shut_door(p, "door", office, Side::kSouth, 300, 0));
  plan.add(Panel{"whiteboard", office, Side::kEast, {1200, 3600, 1000, 2000}, p.board});
  plan.add(Panel{"pinboard", office, Side::kWest, {1500, 3000, 1000, 2000}, p.base});
  return plan;
}

void build_lamps(ModelBuilder& out, const Palette& p) {
  int number = 0;
  for (double y : {1.125, 3.375})
    for (double x : {1.0, 3.0, 5.0})
      linear_lamp(out, p, "office/lamp" + std::to_string(++number),
                  {x, y, metres(kHeight) - kLampDrop}, true);
}

void build_furniture(ModelBuilder& out, const Palette& p, Furnish grade, std::uint64_t seed) {
  Dice dice(seed, "office");
  const FurniturePaints paints = furniture_paints(out, p.lamp);
  Furnisher f{out, paints, grade, "office"};
  const auto near = [&](double value) { return value + dice.uniform(-.04, .04); };
  const double east = metres(kWidth) - kFromWall;
  workstation(f, 1, placed({east, near(3.12), 0}, -90), dice);
  workstation(f, 2, placed({east, near(1.1), 0}, -90), dice);
  workstation(f, 3, placed({kFromWall, near(3.15), 0}, 90), dice);
  plant(f, 1, placed({near(3), near(4.15), 0}, 0), dice);
  for (int i = 1; i <= kWorkstations; ++i) {
    // The faces that are left, shared among the bookcases still to come.
    constexpr int kCaseFaces = 28;
    const int cases = kWorkstations - i + 1;
    const int left = paper_patches(grade) - static_cast<int>(out.counts().patches);
    bookcase(f, i, placed({near(1.2) + .96 * i, kFromWall, 0}, 180),
             (left - cases * kCaseFaces) / cases, dice);
  }
}

}  // namespace

GeneratedModel office(Furnish furnish, std::uint64_t seed) {
  ModelBuilder out;
  const Palette p = make_palette(out, kLampLuminance);
  Plan plan = office_plan(p);
  const Room& room = plan.room(0);
  plan.build(0, out);
  build_radiator(out, p, room, {"radiator1", 0, Side::kNorth, 900, 2500});
  build_radiator(out, p, room, {"radiator2", 0, Side::kNorth, 3500, 5100});
  build_pipe(out, p.metal, room, {"pipe1", 0, {.12, 4.38}, 4, .06});
  build_pipe(out, p.metal, room, {"pipe2", 0, {5.88, 4.38}, 4, .06});
  build_lamps(out, p);
  if (furnish == Furnish::kNone) return out.take("office");
  build_furniture(out, p, furnish, seed);
  return out.take(furnish == Furnish::kLow ? "office-low" : "office-high");
}

}  // namespace atrium::generator
