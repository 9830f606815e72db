#include "visibility/remainder.h"

#include <algorithm>

namespace atrium {

namespace {

struct Halves {
  ConvexPiece front, back;  // either may be empty
  bool fits = true;
};

void push(ConvexPiece& piece, const Vec3& x, bool& fits) {
  if (piece.corners < ConvexPiece::kMaxCorners)
    piece.at[piece.corners++] = x;
  else
    fits = false;
}

// Both parts of a convex piece; corners within the tolerance of the plane are on it.
Halves halve(const ConvexPiece& piece, const Plane& plane, double tolerance) {
  std::array<double, ConvexPiece::kMaxCorners> distance;
  bool front = false, back = false;
  for (std::size_t i = 0; i < piece.corners; ++i) {
    distance[i] = plane.distance(piece.at[i]);
    front |= distance[i] > tolerance;
    back |= distance[i] < -tolerance;
  }
  Halves halves;
  if (front && !back) halves.front = piece;
  if (back && !front) halves.back = piece;
  if (!front || !back) return halves;
  for (std::size_t i = 0; i < piece.corners; ++i) {
    const std::size_t j = i + 1 < piece.corners ? i + 1 : 0;
    const double a = distance[i], b = distance[j];
    if (a >= -tolerance) push(halves.front, piece.at[i], halves.fits);
    if (a <= tolerance) push(halves.back, piece.at[i], halves.fits);
    if ((a > tolerance && b < -tolerance) || (a < -tolerance && b > tolerance)) {
      const Vec3 cut = piece.at[i] + (piece.at[j] - piece.at[i]) * (a / (a - b));
      push(halves.front, cut, halves.fits);
      push(halves.back, cut, halves.fits);
    }
  }
  return halves;
}

}  // namespace

ConvexPiece in_front(const ConvexPiece& piece, const Plane& plane, bool& fits) {
  const Halves halves = halve(piece, plane, 0);
  fits = fits && halves.fits;
  return halves.front;
}

Remainder::Remainder(PolygonView polygon) {
  overflow = polygon.size() > ConvexPiece::kMaxCorners;
  if (overflow) return;
  count = 1;
  pieces[0].corners = polygon.size();
  std::copy(polygon.begin(), polygon.end(), pieces[0].at.begin());
}

void Remainder::cut_out(std::span<const Plane> planes, double tolerance) {
  std::array<ConvexPiece, kMaxPieces> left;
  std::size_t kept = 0;
  const auto keep = [&](const ConvexPiece& piece) {
    if (kept < left.size())
      left[kept++] = piece;
    else
      overflow = true;
  };
  for (std::size_t p = 0; p < count; ++p) {
    const std::size_t before = kept;
    ConvexPiece inside = pieces[p];
    for (std::size_t i = 0; i < planes.size() && inside.corners >= 3; ++i) {
      const Halves halves = halve(inside, planes[i], tolerance);
      overflow = overflow || !halves.fits;
      if (halves.back.corners >= 3) keep(halves.back);
      inside = halves.front;
    }
    if (overflow) return;
    if (inside.corners >= 3) {
      whole = false;
    } else {  // nothing of it is within: it stays in one piece
      kept = before;
      keep(pieces[p]);
    }
  }
  std::copy_n(left.begin(), kept, pieces.begin());
  count = kept;
}

}  // namespace atrium
