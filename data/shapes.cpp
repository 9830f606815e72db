#include "data/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/check.h"

namespace atrium::generator {

Placement placed(const Vec3& origin, double degrees) {
  const double radians = degrees * std::numbers::pi / 180;
  const auto exact = [](double x) { return std::abs(x) < 1e-15 ? 0 : x; };  // at right angles
  return {origin, exact(std::cos(radians)), exact(std::sin(radians))};
}

PaintId ModelBuilder::paint(const std::string& name, const Spectrum& reflectance,
                            const Spectrum& luminance) {
  auto found = std::ranges::find(model_.paints, name, &Paint::name);
  if (found == model_.paints.end()) {
    model_.paints.push_back({name, reflectance, luminance});
    found = model_.paints.end() - 1;
  }
  return static_cast<PaintId>(found - model_.paints.begin());
}

void ModelBuilder::begin(std::string name) {
  ATRIUM_CHECK(model_.groups.empty() || model_.groups.back().face_count > 0);
  model_.groups.push_back({std::move(name), static_cast<std::uint32_t>(model_.faces.size()), 0});
}

void ModelBuilder::face(PaintId paint, PolygonView corners) {
  ATRIUM_CHECK(!model_.groups.empty() && corners.size() >= 3);
  model_.faces.push_back({paint, static_cast<std::uint32_t>(model_.vertices.size()),
                          static_cast<std::uint32_t>(corners.size())});
  model_.vertices.insert(model_.vertices.end(), corners.begin(), corners.end());
  ++model_.groups.back().face_count;
}

void ModelBuilder::rectangle(PaintId paint, int axis, int sign, const Vec3& lo, const Vec3& hi) {
  ATRIUM_CHECK(lo[axis] == hi[axis]);
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  std::array<Vec3, 4> corners{lo, lo, hi, lo};
  corners[1][a] = hi[a];
  corners[3][b] = hi[b];
  if (sign < 0) std::swap(corners[1], corners[3]);
  face(paint, corners);
}

void ModelBuilder::box(PaintId paint, const Vec3& lo, const Vec3& hi, unsigned omit,
                       const Placement& at) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int up = 0; up < 2; ++up) {
      if (omit & (1u << (2 * axis + up))) continue;
      Vec3 from = lo, to = hi;
      (up ? from : to)[axis] = (up ? hi : lo)[axis];
      rectangle(paint, axis, up ? 1 : -1, from, to);
      for (Vec3& v : std::span(model_.vertices).last(4)) v = at(v);
    }
  }
}

void ModelBuilder::prism(PaintId paint, std::span<const Vec2> outline, double z0, double z1,
                         unsigned omit, const Placement& at) {
  const std::size_t n = outline.size();
  Polygon low, high;
  for (const Vec2& p : outline) {
    low.push_back(at({p.x, p.y, z0}));
    high.push_back(at({p.x, p.y, z1}));
  }
  for (std::size_t i = 0, j = n - 1; i < n; j = i++)
    face(paint, {low[j], low[i], high[i], high[j]});
  if (!(omit & kTopFace)) face(paint, high);
  std::ranges::reverse(low);
  if (!(omit & kBottomFace)) face(paint, low);
}

void ModelBuilder::stump(PaintId paint, const Vec2& center, int sides, double r0, double z0,
                         double r1, double z1, unsigned omit, const Placement& at) {
  Polygon low, high;
  for (int i = 0; i < sides; ++i) {
    const double t = 2 * std::numbers::pi * (i + 0.5) / sides;
    const Vec3 d(std::cos(t), std::sin(t), 0), c(center.x, center.y, 0);
    low.push_back(at(c + r0 * d + Vec3(0, 0, z0)));
    high.push_back(at(c + r1 * d + Vec3(0, 0, z1)));
  }
  const std::size_t n = low.size();
  for (std::size_t i = 0, j = n - 1; i < n; j = i++)
    face(paint, {low[j], low[i], high[i], high[j]});
  if (!(omit & kTopFace)) face(paint, high);
  std::ranges::reverse(low);
  if (!(omit & kBottomFace)) face(paint, low);
}

GeneratedModel ModelBuilder::take(std::string title) {
  model_.title = std::move(title);
  return std::move(model_);
}

namespace {

Rect transposed(const Rect& r) { return {r.b0, r.b1, r.a0, r.a1}; }

// Rows of constant b; a piece is drawn on through the next row if that leaves the same interval.
std::vector<Rect> cut_in_rows(const Rect& outer, std::span<const Rect> holes) {
  std::vector<int> levels{outer.b0, outer.b1};
  for (const Rect& h : holes) {
    levels.push_back(std::clamp(h.b0, outer.b0, outer.b1));
    levels.push_back(std::clamp(h.b1, outer.b0, outer.b1));
  }
  std::ranges::sort(levels);
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());

  std::vector<Rect> in_order(holes.begin(), holes.end());
  std::ranges::sort(in_order, {}, &Rect::a0);
  std::vector<Rect> pieces;
  for (std::size_t i = 0; i + 1 < levels.size(); ++i) {
    const Rect row{outer.a0, outer.a1, levels[i], levels[i + 1]};
    const auto add = [&](int a0, int a1) {
      if (a0 >= a1) return;
      const auto below = std::ranges::find_if(
          pieces, [&](const Rect& p) { return p.b1 == row.b0 && p.a0 == a0 && p.a1 == a1; });
      if (below != pieces.end()) {
        below->b1 = row.b1;
      } else {
        pieces.push_back({a0, a1, row.b0, row.b1});
      }
    };
    int from = row.a0;
    for (const Rect& h : in_order) {
      if (!h.overlaps(row)) continue;
      add(from, std::min(h.a0, row.a1));
      from = std::max(from, h.a1);
    }
    add(from, row.a1);
  }
  return pieces;
}

}  // namespace

std::vector<Rect> cut_out(const Rect& outer, std::span<const Rect> holes) {
  std::vector<Rect> turned;
  for (const Rect& h : holes) turned.push_back(transposed(h));
  std::vector<Rect> rows = cut_in_rows(outer, holes);
  std::vector<Rect> columns = cut_in_rows(transposed(outer), turned);
  if (rows.size() <= columns.size()) return rows;
  for (Rect& r : columns) r = transposed(r);
  return columns;
}

}  // namespace atrium::generator
