#include "data/furniture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace atrium::generator {
namespace {

constexpr double kDeskTop = .75, kDeskDepth = .8, kDeskWidth = 1.6;  // m
constexpr int kBookFaces = 5;
constexpr int kLegSides = 8, kVesselSides = 12, kCornerSteps = 3;  // where the grade is fine
constexpr unsigned kEnds = kTopFace | kBottomFace;

// The placement `inner`, within the frame of `outer`.
Placement within(const Placement& outer, const Placement& inner) {
  return {outer(inner.origin), outer.cosine * inner.cosine - outer.sine * inner.sine,
          outer.sine * inner.cosine + outer.cosine * inner.sine};
}

// A rectangle with its corners cut round, `steps` edges each.
std::vector<Vec2> rounded(const Vec2& lo, const Vec2& hi, double radius, int steps) {
  std::vector<Vec2> outline;
  const std::array<Vec2, 4> centers{
      Vec2(hi.x - radius, hi.y - radius), Vec2(lo.x + radius, hi.y - radius),
      Vec2(lo.x + radius, lo.y + radius), Vec2(hi.x - radius, lo.y + radius)};
  for (std::size_t corner = 0; corner < centers.size(); ++corner) {
    for (int i = 0; i <= steps; ++i) {
      const double t =
          (static_cast<double>(corner) + static_cast<double>(i) / steps) * std::numbers::pi / 2;
      outline.push_back(centers[corner] + radius * Vec2(std::cos(t), std::sin(t)));
    }
  }
  return outline;
}

// An upright bar between two surfaces: square, or round where the grade is fine.
void leg(Furnisher& f, PaintId paint, const Vec2& c, double half, double z0, double z1,
         const Placement& at) {
  if (f.fine()) {
    f.out.stump(paint, c, kLegSides, half, z0, half, z1, kEnds, at);
  } else {
    f.out.box(paint, {c.x - half, c.y - half, z0}, {c.x + half, c.y + half, z1}, kEnds, at);
  }
}

// Thin boxes on a box's front (towards the user, at y), in columns × rows: drawers, keys, slits.
void studs(Furnisher& f, PaintId paint, const Rect& mm, int columns, int rows, const Vec2& gap,
           double y, double out_by, const Placement& at) {
  const double w = metres(mm.a1 - mm.a0) / columns, h = metres(mm.b1 - mm.b0) / rows;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = metres(mm.a0) + w * i, z = metres(mm.b0) + h * j;
      f.out.box(paint, {x + gap.x / 2, y - out_by, z + gap.y / 2},
                {x + w - gap.x / 2, y, z + h - gap.y / 2}, kNorthFace, at);
    }
  }
}

// The same lying on a surface at height z: keys.
void keys(Furnisher& f, PaintId paint, const Rect& mm, int columns, int rows, double gap, double z,
          double height, const Placement& at) {
  const double w = metres(mm.a1 - mm.a0) / columns, d = metres(mm.b1 - mm.b0) / rows;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const double x = metres(mm.a0) + w * i, y = metres(mm.b0) + d * j;
      f.out.box(paint, {x + gap / 2, y + gap / 2, z},
                {x + w - gap / 2, y + d - gap / 2, z + height}, kBottomFace, at);
    }
  }
}

void table_top(Furnisher& f, PaintId paint, const Vec2& lo, const Vec2& hi, double z0, double z1,
               const Placement& at) {
  if (f.fine()) {
    f.out.prism(paint, rounded(lo, hi, .04, kCornerSteps), z0, z1, kNoFace, at);
  } else {
    f.out.box(paint, {lo.x, lo.y, z0}, {hi.x, hi.y, z1}, kNoFace, at);
  }
}

void four_legs(Furnisher& f, PaintId paint, const Vec2& lo, const Vec2& hi, double z1,
               const Placement& at) {
  constexpr double kHalf = .02, kInset = .05, kFoot = .02;
  for (int i = 0; i < 4; ++i) {
    const Vec2 c(i % 2 ? hi.x - kInset : lo.x + kInset, i / 2 ? hi.y - kInset : lo.y + kInset);
    const double foot = f.fine() ? kFoot : 0;
    if (f.fine())
      f.out.stump(paint, c, kLegSides, kHalf + .01, 0, kHalf + .005, foot, kBottomFace, at);
    leg(f, paint, c, kHalf, foot, z1, at);
  }
}

void desk(Furnisher& f, const Placement& at) {
  constexpr double kThick = .03;
  const Vec2 lo(-kDeskWidth / 2, -kDeskDepth), hi(kDeskWidth / 2, 0);
  table_top(f, f.paints.wood, lo, hi, kDeskTop - kThick, kDeskTop, at);
  four_legs(f, f.paints.metal, lo, hi, kDeskTop - kThick, at);
  f.out.box(f.paints.wood, {lo.x + .12, -.10, .38}, {hi.x - .12, -.08, .68}, kNoFace, at);
}

void pedestal(Furnisher& f, const Placement& at) {
  constexpr double kFront = -.72;
  const double z0 = f.fine() ? .05 : 0;
  f.out.box(f.paints.wood, {.30, kFront, z0}, {.70, -.14, .6}, f.fine() ? kNoFace : kBottomFace,
            at);
  studs(f, f.paints.pale, {300, 700, 60, 600}, 1, 3, Vec2(.012), kFront, .015, at);
  studs(f, f.paints.metal, {440, 560, 60, 600}, 1, 3, {0, .16}, kFront - .015, .02, at);
  if (!f.fine()) return;
  for (int i = 0; i < 4; ++i)
    f.out.stump(f.paints.dark, {i % 2 ? .64 : .36, i / 2 ? -.20 : -.66}, kLegSides, .025, 0, .025,
                z0, kEnds, at);
}

void chair(Furnisher& f, const Placement& at) {
  constexpr double kSeat = .45, kHalf = .22;
  const Furnisher& g = f;
  if (!f.fine()) {
    four_legs(f, f.paints.metal, Vec2(-kHalf), Vec2(kHalf), kSeat - .05, at);
    f.out.box(g.paints.cloth, {-kHalf, -kHalf, kSeat - .05}, {kHalf, kHalf, kSeat}, kNoFace, at);
    for (double x : {-.15, .15}) leg(f, g.paints.metal, {x, -.19}, .015, kSeat, kSeat + .17, at);
    f.out.box(g.paints.cloth, {-.2, -.21, kSeat + .17}, {.2, -.17, kSeat + .47}, kNoFace, at);
    return;
  }
  for (int i = 0; i < 5; ++i) {
    const Placement arm = within(at, placed(Vec3(0), 72 * i + 10));
    f.out.box(g.paints.metal, {.03, -.02, .07}, {.28, .02, .10}, kWestFace, arm);
    f.out.stump(g.paints.dark, {.25, 0}, kLegSides, .02, 0, .02, .07, kEnds, arm);
  }
  f.out.stump(g.paints.metal, Vec2(0), kLegSides, .045, .06, .03, kSeat - .06, kTopFace, at);
  f.out.prism(g.paints.dark, rounded(Vec2(-kHalf), Vec2(kHalf), .06, kCornerSteps), kSeat - .06,
              kSeat - .03, kNoFace, at);
  f.out.prism(g.paints.cloth, rounded(Vec2(-kHalf + .01), Vec2(kHalf - .01), .06, kCornerSteps),
              kSeat - .03, kSeat + .02, kBottomFace, at);
  for (double x : {-.12, .12}) leg(f, g.paints.metal, {x, -.18}, .012, kSeat + .02, kSeat + .2, at);
  f.out.prism(g.paints.cloth, rounded({-.21, -.21}, {.21, -.15}, .029, kCornerSteps), kSeat + .2,
              kSeat + .55, kNoFace, at);
  for (double x : {-.235, .235}) {
    f.out.box(g.paints.metal, {x - .02, -.03, kSeat - .045}, {x + .02, .03, kSeat + .2}, kTopFace,
              at);
    f.out.prism(g.paints.dark, rounded({x - .03, -.13}, {x + .03, .13}, .028, kCornerSteps),
                kSeat + .2, kSeat + .225, kNoFace, at);
  }
}

void monitor(Furnisher& f, const Placement& at) {
  constexpr double kBottom = kDeskTop + .08;
  const auto& p = f.paints;
  if (f.fine()) {
    f.out.stump(p.pale, {0, .02}, kVesselSides, .13, kDeskTop, .11, kDeskTop + .02, kBottomFace,
                at);
    f.out.stump(p.pale, {0, .02}, kLegSides, .05, kDeskTop + .02, .05, kBottom, kEnds, at);
  } else {
    f.out.box(p.pale, {-.12, -.1, kDeskTop}, {.12, .14, kDeskTop + .02}, kBottomFace, at);
    f.out.box(p.pale, {-.05, -.03, kDeskTop + .02}, {.05, .07, kBottom}, kEnds, at);
  }
  f.out.box(p.pale, {-.2, -.1, kBottom}, {.2, .15, kBottom + .34}, kNoFace, at);
  f.out.box(p.screen, {-.17, -.105, kBottom + .05}, {.17, -.1, kBottom + .31}, kNorthFace, at);
  if (!f.fine()) return;
  const auto mm = [](double z) { return static_cast<int>(std::lround(z * 1000)); };
  studs(f, p.dark, {40, 190, mm(kBottom + .012), mm(kBottom + .035)}, 5, 1, Vec2(.012), -.1, .006,
        at);
  keys(f, p.dark, {-150, 150, 0, 130}, 1, 8, .008, kBottom + .34, .004, at);
}

void keyboard(Furnisher& f, const Placement& at) {
  f.out.box(f.paints.pale, {-.23, -.08, kDeskTop}, {.23, .08, kDeskTop + .02}, kBottomFace, at);
  keys(f, f.paints.dark, {-220, 220, -72, 72}, f.fine() ? 11 : 1, 5, .004, kDeskTop + .02, .008,
       at);
}

void computer(Furnisher& f, const Placement& at) {
  constexpr double kFront = -.66;
  f.out.box(f.paints.pale, {-.68, kFront, 0}, {-.49, -.2, .43}, kBottomFace, at);
  studs(f, f.paints.dark, {-665, -505, 280, 410}, 1, 2, Vec2(.015), kFront, .006, at);
  if (f.fine()) studs(f, f.paints.dark, {-665, -505, 40, 240}, 1, 6, Vec2(.008), kFront, .004, at);
}

// One luminous face.
void desk_lamp(Furnisher& f, const Placement& at) {
  constexpr double kArm = kDeskTop + .42, kArmThick = .02;
  const auto& p = f.paints;
  const int sides = f.fine() ? kVesselSides : 6;
  f.out.stump(p.dark, Vec2(0), sides, .09, kDeskTop, .08, kDeskTop + .025, kBottomFace, at);
  leg(f, p.dark, Vec2(0), .009, kDeskTop + .025, kArm, at);
  f.out.box(p.dark, {-.012, -.25, kArm}, {.012, .02, kArm + kArmThick}, kSouthFace, at);
  const Vec3 lo(-.1, -.37, kArm - .03), hi(.1, -.25, kArm + .04);
  const double z = lo.z;
  f.out.box(p.dark, lo, hi, kBottomFace, at);
  f.out.face(p.lamp, {at(lo), at({lo.x, hi.y, z}), at({hi.x, hi.y, z}), at({hi.x, lo.y, z})});
}

void telephone(Furnisher& f, const Placement& at) {
  f.out.box(f.paints.dark, {-.1, -.11, kDeskTop}, {.1, .11, kDeskTop + .04}, kBottomFace, at);
  f.out.box(f.paints.dark, {-.09, -.1, kDeskTop + .04}, {-.04, .1, kDeskTop + .07}, kBottomFace,
            at);
  if (f.fine()) keys(f, f.paints.pale, {-10, 80, -80, 20}, 3, 4, .008, kDeskTop + .04, .006, at);
}

// An open vessel that stands on the floor, filled up to `fill`.
void vessel(Furnisher& f, PaintId paint, PaintId content, double r0, double r1, double height,
            double fill, const Placement& at) {
  constexpr double kWall = .01;
  const int n = f.fine() ? kVesselSides : 6;
  const auto ring = [&](double r, double z) {
    Polygon points;
    for (int i = 0; i < n; ++i) {
      const double t = 2 * std::numbers::pi * i / n;
      points.push_back(at({r * std::cos(t), r * std::sin(t), z}));
    }
    return points;
  };
  const double inside = r0 + (r1 - r0) * fill / height - kWall;
  const Polygon foot = ring(r0, 0), rim = ring(r1, height), lip = ring(r1 - kWall, height),
                bottom = ring(inside, fill);
  for (std::size_t i = 0, j = foot.size() - 1; i < foot.size(); j = i++) {
    f.out.face(paint, {foot[j], foot[i], rim[i], rim[j]});
    f.out.face(paint, {rim[j], rim[i], lip[i], lip[j]});
    f.out.face(paint, {lip[j], lip[i], bottom[i], bottom[j]});
  }
  f.out.face(content, bottom);
}

}  // namespace

FurniturePaints furniture_paints(ModelBuilder& out, PaintId lamp) {
  FurniturePaints p;
  p.wood = out.paint("wood", {.50, .36, .22});
  p.pale = out.paint("pale_plastic", {.68, .66, .60});
  p.dark = out.paint("dark_plastic", {.09, .09, .10});
  p.metal = out.paint("metal", {.45, .46, .48});
  p.cloth = out.paint("cloth", {.15, .22, .42});
  p.screen = out.paint("screen", {.06, .08, .08});
  p.leaf = out.paint("leaf", {.09, .32, .10});
  p.soil = out.paint("soil", {.12, .09, .07});
  p.lamp = lamp;
  p.books = {out.paint("book_red", {.50, .12, .10}), out.paint("book_blue", {.13, .20, .45}),
             out.paint("book_green", {.15, .35, .18}), out.paint("book_cream", {.72, .68, .55})};
  return p;
}

void Furnisher::begin(const std::string& piece, int number) {
  out.begin(room + "/furniture/" + piece + std::to_string(number));
}

void workstation(Furnisher& f, int number, const Placement& at, Dice& dice) {
  const auto turned = [&](const Vec3& where, double most_degrees) {
    return within(at, placed(where, dice.uniform(-most_degrees, most_degrees)));
  };
  f.begin("desk", number), desk(f, at);
  f.begin("pedestal", number), pedestal(f, at);
  f.begin("chair", number), chair(f, turned({-.1, -1.2, 0}, 20));
  f.begin("monitor", number), monitor(f, turned({-.12, -.3, 0}, 12));
  f.begin("keyboard", number), keyboard(f, turned({-.12, -.62, 0}, 5));
  f.begin("computer", number), computer(f, at);
  f.begin("desk_lamp", number), desk_lamp(f, turned({.62, -.17, 0}, 15));
  f.begin("telephone", number), telephone(f, turned({.5, -.62, 0}, 10));
  f.begin("bin", number);
  vessel(f, f.paints.dark, f.paints.dark, .11, .14, .32, .02, turned({-.98, -.4, 0}, 30));
}

int usual_book_faces(Furnish grade) { return grade == Furnish::kHigh ? 250 : 170; }

int bookcase(Furnisher& f, int number, const Placement& at, int book_faces, Dice& dice) {
  constexpr double kSide = .02, kHalf = .45, kDepth = .3, kHeight = 1.8, kBoard = .02;
  constexpr double kFirst = .08, kPitch = .33;  // boards
  constexpr int kBoards = 5;
  const auto& p = f.paints;
  f.begin("bookcase", number);
  for (double x : {-kHalf, kHalf - kSide})
    f.out.box(p.wood, {x, -kDepth, 0}, {x + kSide, 0, kHeight}, kBottomFace, at);
  const double x0 = -kHalf + kSide, x1 = kHalf - kSide;
  f.out.box(p.wood, {x0, -.03, 0}, {x1, -.01, kHeight - .05}, kWestFace | kEastFace | kBottomFace,
            at);
  for (int b = 0; b < kBoards; ++b) {
    const double z = kFirst + kPitch * b;
    f.out.box(p.wood, {x0, -kDepth + .01, z}, {x1, -.03, z + kBoard},
              kWestFace | kEastFace | kNorthFace, at);
  }

  f.begin("books", number);
  int left = book_faces, board = 0;
  double x = x0 + .01;
  while (left >= kBookFaces) {
    const double thick = f.fine() ? dice.uniform(.018, .036) : dice.uniform(.035, .06);
    const double tall = dice.uniform(.18, .28), deep = dice.uniform(.14, .22);
    if (x + thick > x1 - .01) {
      x = x0 + .01;
      if (++board == kBoards) break;
    }
    const double z = kFirst + kPitch * board + kBoard;
    const PaintId paint = p.books[static_cast<std::size_t>(dice.integer(0, 3))];
    if (left >= 2 * kBookFaces) {
      f.out.box(paint, {x, -.05 - deep, z}, {x + thick, -.05, z + tall}, kBottomFace, at);
      left -= kBookFaces;
    } else {  // a box for the last sheets, with as many sides as are left
      f.out.stump(paint, {x + thick / 2, -.15}, left - 1, thick / 2, z, thick / 2, z + tall,
                  kBottomFace, at);
      left = 0;
    }
    x += thick + .003;
  }
  return book_faces - left;
}

void plant(Furnisher& f, int number, const Placement& at, Dice& dice) {
  constexpr double kRim = .3;
  f.begin("plant", number);
  vessel(f, f.paints.pale, f.paints.soil, .13, .17, kRim, kRim - .03, at);
  const int leaves = f.fine() ? 30 : 10;
  for (int i = 0; i < leaves; ++i) {
    const double t = 2 * std::numbers::pi * (i + dice.uniform(0, .5)) / leaves;
    const double z = kRim + .02 + .7 * i / leaves, reach = dice.uniform(.12, .22);
    const Vec3 out_dir(std::cos(t), std::sin(t), 0), across(-std::sin(t), std::cos(t), 0);
    const Vec3 root = .01 * out_dir + Vec3(0, 0, z);
    const Vec3 tip = root + reach * out_dir + Vec3(0, 0, dice.uniform(-.02, .12));
    const Vec3 a = at(root + .03 * across), b = at(root - .03 * across),
               c = at(root + Vec3(0, 0, .012)), d = at(tip);
    for (const auto& [u, v, w] : {std::array{b, a, d}, {c, b, d}, {a, c, d}, {a, b, c}})
      f.out.face(f.paints.leaf, {u, v, w});
  }
}

void school_table(Furnisher& f, int number, const Placement& at) {
  const Vec2 lo(-.7, -.5), hi(.7, 0);
  f.begin("table", number);
  table_top(f, f.paints.wood, lo, hi, .72, .75, at);
  four_legs(f, f.paints.metal, lo, hi, .72, at);
  for (int i = 0; i < 2; ++i) {
    f.begin("chair", 2 * number - 1 + i);
    chair(f, within(at, placed({i ? .35 : -.35, -.72, 0}, 0)));
  }
}

}  // namespace atrium::generator
