#include "solver/form_factor.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "solver/triangle_cubature.h"

namespace atrium {

namespace {

constexpr double kPi = std::numbers::pi;

// Corners that fit on the stack, the common case; twice as many for clipping.
constexpr std::size_t kStackCorners = 16;

// A contour sum below this share of its terms' magnitudes has lost half its digits.
constexpr double kCancelled = 1e-7;

// x counts as on an edge when the edge's two ends are seen this close to opposite directions.
constexpr double kOnEdge = 1e-13;

// How far to step off an edge to take the limit there, of the polygon's width.
constexpr double kStepOff = 1e-9;

// Terms worked on at a time: written as loops of this length that compilers turn into vectors.
constexpr int kLanes = 4;

// The polygon seen from x: corners relative to it, and the edges that follow them.
struct View {
  std::array<Vec3, 2 * kStackCorners> stack_corner, stack_edge;
  std::vector<Vec3> heap_corner, heap_edge;
  std::span<Vec3> corner, edge;

  void reserve(std::size_t n) {
    if (n <= stack_corner.size()) {
      corner = std::span(stack_corner).first(n);
      edge = std::span(stack_edge).first(n);
      return;
    }
    heap_corner.resize(n);
    heap_edge.resize(n);
    corner = heap_corner;
    edge = heap_edge;
  }
  void shrink(std::size_t n) {
    corner = corner.first(n);
    edge = edge.first(n);
  }
};

struct ContourSum {
  double c = 0;          // the configuration factor, negative from behind
  double magnitude = 0;  // of its terms
  bool on_edge = false;
};

// atan(y / x) in [0, π] for y >= 0, to 2 ulp, without branches. [Cephes]
inline double angle(double x, double y) {
  const double ax = std::abs(x);
  const double low = y < ax ? y : ax, high = y < ax ? ax : y;
  const bool wide = low > 0.66 * high;
  const double t = (wide ? low - high : low) / (wide ? low + high : high);
  const double z = t * t;
  const double p = ((((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z -
                      7.500855792314704667340e1) *
                         z -
                     1.228866684490136173410e2) *
                        z -
                    6.485021904942025371773e1);
  const double q = (((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z +
                      4.328810604912902668951e2) *
                         z +
                     4.853903996359136964868e2) *
                        z +
                    1.945506571482613964425e2);
  double a = t + t * z * (p / q) + (wide ? kPi / 4 : 0.0);
  a = y > ax ? kPi / 2 - a : a;
  return x < 0 ? kPi - a : a;
}

// Lambert's formula: C = -(1/2π) Σ θi n·Γi, Γi the unit normal of the plane through x and edge i
// and θi the angle that the edge subtends.
ContourSum contour_sum(const View& view, const Vec3& n) {
  ContourSum sum;
  const std::size_t count = view.corner.size();
  for (std::size_t first = 0; first < count; first += kLanes) {
    double sine_squared[kLanes], cosine[kLanes], height[kLanes], term[kLanes];
    for (int k = 0; k < kLanes; ++k) {
      const std::size_t i = first + k;
      if (i >= count) {  // an edge without length
        sine_squared[k] = height[k] = 0;
        cosine[k] = 1;
        continue;
      }
      const Vec3& r = view.corner[i];
      const Vec3 g = cross(r, view.edge[i]);
      sine_squared[k] = dot(g, g);
      cosine[k] = dot(r, view.corner[i + 1 < count ? i + 1 : 0]);
      height[k] = dot(n, g);
    }
    for (int k = 0; k < kLanes; ++k) {
      const double sine = std::sqrt(sine_squared[k]);
      term[k] = sine > 0 ? height[k] * (angle(cosine[k], sine) / sine) : 0.0;
      sum.on_edge |= sine <= -kOnEdge * cosine[k] || (sine == 0 && cosine[k] == 0);
    }
    for (int k = 0; k < kLanes; ++k) {
      sum.c -= term[k];
      sum.magnitude += std::abs(term[k]);
    }
  }
  sum.c /= 2 * kPi;
  sum.magnitude /= 2 * kPi;
  return sum;
}

enum class Horizon { kAbove, kBelow, kCut };

// Sets up the view of the polygon above the horizon of (x, n). Of a concave polygon the parts stay
// joined along the horizon, by edges there and back that cancel.
Horizon look(const Vec3& x, const Vec3& n, PolygonView polygon, View& view) {
  const std::size_t count = polygon.size();
  view.reserve(count);
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (std::size_t i = 0; i < count; ++i) {
    view.corner[i] = polygon[i] - x;
    const double h = dot(n, view.corner[i]);
    lowest = std::min(lowest, h);
    highest = std::max(highest, h);
  }
  if (!(highest > 0)) return Horizon::kBelow;
  if (lowest >= 0) {
    for (std::size_t i = 0; i < count; ++i)
      view.edge[i] = polygon[i + 1 < count ? i + 1 : 0] - polygon[i];
    return Horizon::kAbove;
  }
  View all;
  all.reserve(count);
  std::copy(view.corner.begin(), view.corner.end(), all.corner.begin());
  view.reserve(2 * count);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 &a = all.corner[i], &b = all.corner[i + 1 < count ? i + 1 : 0];
    const double ha = dot(n, a), hb = dot(n, b);
    if (ha >= 0) view.corner[kept++] = a;
    if ((ha > 0 && hb < 0) || (ha < 0 && hb > 0))
      view.corner[kept++] = a + (b - a) * (ha / (ha - hb));
  }
  view.shrink(kept);
  for (std::size_t i = 0; i < kept; ++i)
    view.edge[i] = view.corner[i + 1 < kept ? i + 1 : 0] - view.corner[i];
  return Horizon::kCut;
}

// Adaptive cubature of cosθ cosθ' / π r² from the origin over triangles above its horizon and with
// their fronts to it: no term is negative, so none cancels.
class PointCubature {
 public:
  PointCubature(const Vec3& n, double distance) : n_(n), distance_(distance) {}

  double integrate(const Triangle& t) {
    const double coarse = apply<3>(t), fine = apply<5>(t);
    const double error = error_of_finer(coarse, fine);
    if (error <= kRelative * fine || error <= kNegligible * total_ || ++pieces_ >= kPieces) {
      total_ += fine;
      return fine;
    }
    const auto [a, b] = bisect(t);
    return integrate(a) + integrate(b);
  }

 private:
  static constexpr double kRelative = 1e-10;
  static constexpr double kNegligible = 1e-13;
  static constexpr int kPieces = 2000;  // not before rounding alone keeps the rules apart

  template <int kNodes>
  double apply(const Triangle& t) const {
    const TriangleRule<kNodes> rule(t);
    double sum = 0;
    for (std::size_t i = 0; i < rule.at.size(); ++i) {
      const double r2 = dot(rule.at[i], rule.at[i]);
      sum += rule.weight[i] * std::max(0.0, dot(n_, rule.at[i])) / (r2 * r2);
    }
    return sum * area(t) * distance_ / kPi;
  }

  Vec3 n_;
  double distance_;  // of the origin from the triangles' plane
  double total_ = 0;
  int pieces_ = 0;
};

double by_cubature(const Vec3& x, const Vec3& n, PolygonView polygon) {
  const Plane plane = plane_of(polygon);
  // From the nearest corner, where the difference loses least.
  const Vec3 nearest = *std::min_element(
      polygon.begin(), polygon.end(),
      [&](const Vec3& a, const Vec3& b) { return dot(a - x, a - x) < dot(b - x, b - x); });
  const double distance = dot(plane.normal, x - nearest);
  const double noise = 8 * std::numeric_limits<double>::epsilon() * length(polygon[0] - x);
  if (!(distance > noise)) return 0;
  std::vector<Triangle> triangles;
  if (!triangulate(polygon, triangles)) return 0;
  for (Triangle& t : triangles)
    for (Vec3& corner : t) corner -= x;
  PointCubature cubature(n, distance);
  double sum = 0;
  for (const Triangle& t : clip(triangles, Plane{n, 0}, 0)) sum += cubature.integrate(t);
  return std::min(sum, 1.0);
}

// x is on the polygon's rim: the limit coming from the polygon's front within x's own plane.
double on_the_rim(const Vec3& x, const Vec3& n, PolygonView polygon) {
  const Vec3 front = plane_of(polygon).normal;
  const Vec3 along = front - dot(front, n) * n;
  const double slope = length(along);
  const Vec3 way = slope > std::sqrt(kStepOff) ? along / slope : front;
  const double step = kStepOff * bounds(polygon).diagonal();
  View view;
  const Vec3 beside = x + step * way;
  if (look(beside, n, polygon, view) == Horizon::kBelow) return 0;
  return std::clamp(contour_sum(view, n).c, 0.0, 1.0);
}

}  // namespace

namespace {

// By the contour, and how far it is to be trusted.
struct ByContour {
  double factor = 0;
  bool cancelled = false;  // half of its digits are lost
};

ByContour by_contour(const Vec3& x, const Vec3& n, PolygonView polygon) {
  View view;
  const Horizon horizon = look(x, n, polygon, view);
  if (horizon == Horizon::kBelow) return {};
  const ContourSum sum = contour_sum(view, n);
  if (sum.on_edge) return {on_the_rim(x, n, polygon), false};
  // A cut moves corners by a rounding of their distance, not of the edges' lengths.
  const double magnitude = horizon == Horizon::kCut ? std::max(1.0, sum.magnitude) : sum.magnitude;
  return {std::clamp(sum.c, 0.0, 1.0), !(std::abs(sum.c) > kCancelled * magnitude)};
}

}  // namespace

double point_to_polygon(const Vec3& x, const Vec3& n, PolygonView polygon) {
  const ByContour contour = by_contour(x, n, polygon);
  return contour.cancelled ? by_cubature(x, n, polygon) : contour.factor;
}

double point_to_polygon_in_sum(const Vec3& x, const Vec3& n, PolygonView polygon) {
  return by_contour(x, n, polygon).factor;
}

}  // namespace atrium
