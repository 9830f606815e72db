#include "engine/import/subtract.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <polyclipping/clipper.hpp>

#include "engine/import/mesh.h"
#include "engine/import/plane_pieces.h"

namespace atrium {
namespace {

// Clipper computes in whole numbers: the farthest coordinate is this many units, so that crossings
// are exact to 1e-13 of it.
constexpr double kLargestUnit = 17592186044416.0;  // 2^44
// Of the tolerance: corners and necks of the difference that do not count.
constexpr double kCleanShare = 0.25;

using GridPoint = std::pair<ClipperLib::cInt, ClipperLib::cInt>;

class Difference {
 public:
  Difference(PolygonView polygon, std::span<const PolygonView> others, double tolerance)
      : polygon_(polygon),
        others_(others),
        tolerance_(tolerance),
        frame_(frame_for(plane_of(polygon), polygon)),
        scale_(kLargestUnit / farthest()) {}

  std::vector<Polygon> pieces() {
    ClipperLib::Clipper clipper;
    clipper.AddPath(path(polygon_), ClipperLib::ptSubject, true);
    for (const PolygonView& other : others_) clipper.AddPath(path(other), ClipperLib::ptClip, true);
    ClipperLib::Paths rest;
    if (!clipper.Execute(ClipperLib::ctDifference, rest, ClipperLib::pftNonZero,
                         ClipperLib::pftNonZero))
      return halved();
    ClipperLib::CleanPolygons(rest, kCleanShare * tolerance_ * scale_);
    std::vector<Ring> loops;
    for (const ClipperLib::Path& p : rest)
      if (p.size() >= 3 && !narrow(p)) loops.push_back(ring(p));
    if (loops.empty()) return {};
    double slack = 0;
    for (const Ring& loop : loops) slack += tolerance_ * perimeter(flat_, loop);
    const auto rings = convex_pieces(flat_, loops, tolerance_, slack);
    if (!rings) return halved();
    std::vector<Polygon> result;
    for (const Ring& r : *rings) {
      Polygon piece;
      for (const std::uint32_t i : r)
        piece.push_back(i < corners_.size() ? corners_[i] : frame_.to_space(flat_[i]));
      if (width(piece) > tolerance_) result.push_back(std::move(piece));
    }
    return result;
  }

 private:
  double farthest() const {
    double most = 0;
    const auto extend = [&](PolygonView p) {
      for (const Vec3& x : p) most = std::max(most, length(frame_.to_plane(x)));
    };
    extend(polygon_);
    for (const PolygonView& other : others_) extend(other);
    return most;
  }

  ClipperLib::Path path(PolygonView p) {
    ClipperLib::Path out;
    for (const Vec3& x : p) {
      const Vec2 q = frame_.to_plane(x);
      const GridPoint g{std::llround(q.x * scale_), std::llround(q.y * scale_)};
      known_.try_emplace(g, x);
      out.push_back({g.first, g.second});
    }
    if (!ClipperLib::Orientation(out)) std::reverse(out.begin(), out.end());
    return out;
  }

  bool narrow(const ClipperLib::Path& p) const {
    ClipperLib::cInt x0 = p[0].X, x1 = x0, y0 = p[0].Y, y1 = y0;
    for (const ClipperLib::IntPoint& g : p) {
      x0 = std::min(x0, g.X), x1 = std::max(x1, g.X);
      y0 = std::min(y0, g.Y), y1 = std::max(y1, g.Y);
    }
    const double extent = std::hypot(static_cast<double>(x1 - x0), static_cast<double>(y1 - y0));
    return 2 * std::abs(ClipperLib::Area(p)) <= tolerance_ * scale_ * extent;
  }

  // A path's corners as numbers of `flat_`: outlines counter-clockwise, holes clockwise.
  Ring ring(const ClipperLib::Path& p) {
    Ring r;
    for (const ClipperLib::IntPoint& g : p) {
      const auto [at, added] =
          numbers_.try_emplace({g.X, g.Y}, static_cast<std::uint32_t>(flat_.size()));
      if (added) {
        const auto known = known_.find({g.X, g.Y});
        const Vec2 q{static_cast<double>(g.X) / scale_, static_cast<double>(g.Y) / scale_};
        corners_.push_back(known != known_.end() ? known->second : frame_.to_space(q));
        flat_.push_back(frame_.to_plane(corners_.back()));
      }
      r.push_back(at->second);
    }
    return r;
  }

  // The difference by half planes: more pieces, but nothing can go wrong.
  std::vector<Polygon> halved() const {
    std::vector<Polygon> rest{Polygon(polygon_.begin(), polygon_.end())};
    for (const PolygonView& other : others_) {
      const double sense = dot(area_vector(other), frame_.n) > 0 ? 1 : -1;
      std::vector<Polygon> next;
      for (Polygon& piece : rest) {
        Polygon inside = std::move(piece);
        for (std::size_t i = 0; i < other.size() && !inside.empty(); ++i) {
          const Vec3& a = other[i];
          const Vec3 edge = other[(i + 1) % other.size()] - a;
          if (!(length(edge) > 0)) continue;
          const Vec3 outward = sense * normalize(cross(edge, frame_.n));
          Split s = split(inside, {outward, dot(outward, a)}, tolerance_);
          if (!s.front.empty() && width(s.front) > tolerance_) next.push_back(std::move(s.front));
          inside = std::move(s.back);
        }
      }
      rest = std::move(next);
    }
    return rest;
  }

  const PolygonView polygon_;
  const std::span<const PolygonView> others_;
  const double tolerance_;
  const Frame frame_;
  const double scale_;               // units a metre
  std::map<GridPoint, Vec3> known_;  // corners of the polygons given
  std::map<GridPoint, std::uint32_t> numbers_;
  std::vector<Vec2> flat_;
  std::vector<Vec3> corners_;
};

}  // namespace

std::vector<Polygon> subtract(PolygonView polygon, std::span<const PolygonView> others,
                              double tolerance) {
  return Difference(polygon, others, tolerance).pieces();
}

}  // namespace atrium
