#include "visibility/patch_cut.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

namespace atrium {

namespace {

// A wall cuts a patch within one room if it stands on this share of the cut; between rooms any part
// that is more than a touch will do.
constexpr double kWallOfCut = 0.5;
constexpr double kTouchOfCut = 1e-3;
// All of a patch counts as lit if no more than this share of it is not.
constexpr double kDarkShare = 1e-6;

struct SharedEdge {
  std::size_t front, back;  // the edges' first vertices in either polygon
  Vec3 a, b;
};

class Cutter {
 public:
  Cutter(const Bsp& bsp, const std::vector<bool>& lit, const Rooms& rooms, const Vec3& side)
      : bsp_(bsp), lit_(lit), rooms_(rooms), side_(side) {}

  std::vector<PatchPiece> cut(BspRef from, Polygon polygon) const {
    if (from.is_cell()) {
      if (!lit_[from.index()]) return {};
      PatchPiece piece{polygon, {}};
      piece.pieces.push_back({from.index(), std::move(polygon)});
      return {std::move(piece)};
    }
    const BspNode& node = bsp_.nodes[from.index()];
    const DropSide where = drop_side(node.plane, polygon, side_, bsp_.tolerance);
    if (where == DropSide::kFront) return cut(node.front, std::move(polygon));
    if (where == DropSide::kBack) return cut(node.back, std::move(polygon));
    Split parts = split_off_slivers(polygon, node.plane, bsp_.tolerance);
    if (parts.back.empty()) return cut(node.front, std::move(parts.front));
    if (parts.front.empty()) return cut(node.back, std::move(parts.back));
    std::vector<PatchPiece> front = cut(node.front, std::move(parts.front));
    std::vector<PatchPiece> back = cut(node.back, std::move(parts.back));
    return rejoin(node, polygon, std::move(front), std::move(back));
  }

 private:
  // Undoes the cut between pieces wherever nothing stands on it.
  std::vector<PatchPiece> rejoin(const BspNode& node, const Polygon& polygon,
                                 std::vector<PatchPiece> front,
                                 std::vector<PatchPiece> back) const {
    if (std::optional<PatchPiece> whole = keep_whole(node, polygon, front, back))
      return {std::move(*whole)};
    for (PatchPiece& f : front) {
      for (PatchPiece& b : back) {
        if (b.polygon.empty()) continue;
        const std::optional<SharedEdge> edge = shared_edge(node.plane, f.polygon, b.polygon);
        if (!edge || wall_stands_on(node, *edge, f, b)) continue;
        Polygon joined = join(f.polygon, b.polygon, *edge);
        if (!is_convex(joined, bsp_.tolerance)) continue;
        f.polygon = std::move(joined);
        std::move(b.pieces.begin(), b.pieces.end(), std::back_inserter(f.pieces));
        b.polygon.clear();
        break;
      }
    }
    for (PatchPiece& b : back)
      if (!b.polygon.empty()) front.push_back(std::move(b));
    return front;
  }

  // All of the polygon as one piece, if it lies in one room, is lit throughout, and no wall
  // stands on the cut.
  std::optional<PatchPiece> keep_whole(const BspNode& node, const Polygon& polygon,
                                       const std::vector<PatchPiece>& front,
                                       const std::vector<PatchPiece>& back) const {
    PatchPiece whole{polygon, {}};
    for (const auto* half : {&front, &back})
      for (const PatchPiece& piece : *half)
        whole.pieces.insert(whole.pieces.end(), piece.pieces.begin(), piece.pieces.end());
    if (!in_one_room(whole)) return {};
    double lit = 0;
    for (const CellPiece& piece : whole.pieces) lit += area(piece.polygon);
    if (lit < (1 - kDarkShare) * area(polygon)) return {};
    const Polygon part = clip(polygon, node.plane, bsp_.tolerance);
    const std::optional<std::size_t> edge = edge_in(node.plane, part);
    if (!edge) return {};
    const Vec3 &a = part[*edge], &b = part[(*edge + 1) % part.size()];
    if (covered_by_wall(node, a, b) >= kWallOfCut * length(b - a)) return {};
    return whole;
  }

  bool in_one_room(const PatchPiece& piece) const {
    return !piece.pieces.empty() &&
           std::all_of(piece.pieces.begin(), piece.pieces.end(), [&](const CellPiece& p) {
             return rooms_.of_cell[p.cell] == rooms_.of_cell[piece.pieces[0].cell];
           });
  }

  // How many metres of a cut a wall stands on, on the patch's lit side.
  double covered_by_wall(const BspNode& node, const Vec3& a, const Vec3& b) const {
    const Vec3 off = kSliverTolerances * bsp_.tolerance * side_;
    return node.opaque.empty() ? 0 : covered_length(node.opaque, a + off, b + off);
  }

  std::optional<std::size_t> edge_in(const Plane& plane, const Polygon& polygon) const {
    const std::size_t n = polygon.size();
    for (std::size_t i = 0; i < n; ++i)
      if (std::abs(plane.distance(polygon[i])) <= bsp_.tolerance &&
          std::abs(plane.distance(polygon[(i + 1) % n])) <= bsp_.tolerance)
        return i;
    return {};
  }

  std::optional<SharedEdge> shared_edge(const Plane& plane, const Polygon& f,
                                        const Polygon& b) const {
    const auto i = edge_in(plane, f), j = edge_in(plane, b);
    if (!i || !j) return {};
    const Vec3 &a = f[*i], &c = f[(*i + 1) % f.size()];
    const Vec3 &d = b[(*j + 1) % b.size()], &e = b[*j];
    const double near = kSliverTolerances * bsp_.tolerance;
    if (length(a - d) > near || length(c - e) > near) return {};
    return SharedEdge{*i, *j, a, c};
  }

  // f's vertices from the shared edge's end round to its start, then b's between; corners that the
  // cut alone had made go again.
  Polygon join(const Polygon& f, const Polygon& b, const SharedEdge& edge) const {
    Polygon out;
    for (std::size_t k = 1; k <= f.size(); ++k) out.push_back(f[(edge.front + k) % f.size()]);
    const std::size_t start = f.size() - 1;  // of the shared edge, its end is 0
    for (std::size_t k = 2; k < b.size(); ++k) out.push_back(b[(edge.back + k) % b.size()]);
    auto straight = [&](std::size_t i) {
      const std::size_t n = out.size();
      const Vec3 &p = out[(i + n - 1) % n], &q = out[(i + 1) % n];
      const double l = length(q - p);
      return !(l > 0) || length(cross(out[i] - p, q - p)) / l <= bsp_.tolerance;
    };
    if (straight(start)) out.erase(out.begin() + static_cast<std::ptrdiff_t>(start));
    if (straight(0)) out.erase(out.begin());
    return out;
  }

  bool wall_stands_on(const BspNode& node, const SharedEdge& edge, const PatchPiece& f,
                      const PatchPiece& b) const {
    const double l = length(edge.b - edge.a), covered = covered_by_wall(node, edge.a, edge.b);
    if (covered >= kWallOfCut * l) return true;
    const double touch = std::max(kTouchOfCut * l, 2 * kSliverTolerances * bsp_.tolerance);
    return covered > touch && !share_a_room(f, b);
  }

  bool share_a_room(const PatchPiece& f, const PatchPiece& b) const {
    for (const CellPiece& p : f.pieces)
      for (const CellPiece& q : b.pieces)
        if (rooms_.of_cell[p.cell] == rooms_.of_cell[q.cell]) return true;
    return false;
  }

  const Bsp& bsp_;
  const std::vector<bool>& lit_;
  const Rooms& rooms_;
  Vec3 side_;
};

}  // namespace

std::vector<PatchPiece> cut_patch(const Bsp& bsp, const std::vector<bool>& lit, const Rooms& rooms,
                                  PolygonView polygon) {
  const Vec3 side = plane_of(polygon).normal;
  return Cutter(bsp, lit, rooms, side).cut(bsp.root, Polygon(polygon.begin(), polygon.end()));
}

PatchPiece clip(const PatchPiece& piece, const Plane& plane, double tolerance) {
  PatchPiece part{clip(piece.polygon, plane, tolerance), {}, piece.footprint};
  for (const CellPiece& p : piece.pieces) {
    CellPiece kept{p.cell, clip(p.polygon, plane, tolerance)};
    if (!kept.polygon.empty()) part.pieces.push_back(std::move(kept));
  }
  if (part.pieces.empty()) part.polygon.clear();
  return part;
}

}  // namespace atrium
