// Form factors between two polygons. Two methods, and each says how far it may be off:
//
//  contour   A1 F12 = (1/2π) ∮∮ ln r dr1·dr2 [Sparrow 63; Schröder & Hanrahan 93], the inner
//  integral
//            in closed form, the outer by adaptive Gauss-Kronrod. Touching edges cost nothing; but
//            its terms cancel where the form factor is small beside the edges' lengths: then it is
//            taken again in long double, for eleven bits more.
//  cubature  of the kernel over pairs of triangles, split until two rules agree. No term is
//            negative, so it holds any number of digits however far or grazing; but near touching
//            edges it would split for ever.
//
// The contour is taken where it keeps eight digits, else the better of the two.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "solver/form_factor.h"
#include "solver/triangle_cubature.h"

namespace atrium {

namespace {

constexpr double kPi = std::numbers::pi;
// An answer is taken where its error is this share of it at most.
constexpr double kGoodEnough = 1e-8;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// A value and how far it may be off.
struct Estimate {
  double value = 0;
  double error = 0;
  bool good_enough() const { return error <= kGoodEnough * value; }
};

// ---- contour

template <class Real>
struct Edge {
  glm::vec<3, Real> from;
  glm::vec<3, Real> direction;  // unit
  Real length;
};

template <class Real>
std::vector<Edge<Real>> edges_of(PolygonView polygon) {
  std::vector<Edge<Real>> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const glm::vec<3, Real> a(polygon[i]), b(polygon[i + 1 < polygon.size() ? i + 1 : 0]);
    const Real l = glm::length(b - a);
    if (l > 0) out.push_back({a, (b - a) / l, l});
  }
  return out;
}

// A sum's value and the magnitude of its terms.
template <class Real>
struct Sum {
  Real value = 0;
  Real magnitude = 0;
};

// ∫ ln|y - x| dy along the edge, which x may touch. Arranged so that a short edge far away keeps
// its digits.
template <class Real>
Sum<Real> log_integral(const glm::vec<3, Real>& x, const Edge<Real>& edge) {
  const glm::vec<3, Real> a = edge.from - x;
  const Real l = edge.length;
  Real u0 = glm::dot(a, edge.direction), u1 = u0 + l;  // along the edge, from the foot of x
  const Real d = glm::length(glm::cross(a, edge.direction));
  if (std::abs(u1) < std::abs(u0)) {  // let the far end be the second
    std::swap(u0, u1);
    u0 = -u0;
    u1 = -u1;
  }
  const Real d2 = d * d, near2 = u0 * u0 + d2, far2 = u1 * u1 + d2;
  // u1 ln r1 - u0 ln r0 = l ln r1 + u0 (ln r1 - ln r0)
  const Real along = l * (std::log(far2) / 2 - 1);
  const Real rise =
      near2 > std::numeric_limits<Real>::min() ? u0 * std::log1p(l * (u0 + u1) / near2) / 2 : 0;
  const Real across = d * std::atan2(d * l, d2 + u0 * u1);
  return {along + rise + across, std::abs(along) + std::abs(rise) + across};
}

// 15 points of Kronrod and the 7 of Gauss among them, on [-1, 1]. [QUADPACK]
constexpr std::array<long double, 8> kKronrodNode = {
    0.991455371120812639206854697526329L, 0.949107912342758524526189684047851L,
    0.864864423359769072789712788640926L, 0.741531185599394439863864773280788L,
    0.586087235467691130294144691693013L, 0.405845151377397166906606412076961L,
    0.207784955007898467600689403773245L, 0.0L};
constexpr std::array<long double, 8> kKronrodWeight = {
    0.022935322010529224963732008058970L, 0.063092092629978553290700663189204L,
    0.104790010322250183839876322541518L, 0.140653259715525918745189590510238L,
    0.169004726639267902826583426598550L, 0.190350578064785409913256402421014L,
    0.204432940075298892414161999234649L, 0.209482141084727828012999174891714L};
constexpr std::array<long double, 4> kGaussWeight = {
    0.129484966168869693270611432679082L, 0.279705391489276667901467771423780L,
    0.381830050505118944950369775488975L, 0.417959183673469387755102040816327L};

template <class Real>
class Contour {
 public:
  Contour(PolygonView p1, PolygonView p2)
      : outer_(edges_of<Real>(p1)), inner_(edges_of<Real>(p2)) {}

  // A1 F12, its error by quadrature and by rounding.
  Estimate integrate() {
    Real magnitude = 0;
    for (const Edge<Real>& e : outer_) magnitude += kronrod(e, 0, e.length).sum.magnitude;
    finest_ = std::numeric_limits<Real>::epsilon() * magnitude;
    for (const Edge<Real>& e : outer_) refine(e, 0, e.length, 0);
    error_ += kRoundings * finest_;
    return {static_cast<double>(value_) / (2 * kPi), static_cast<double>(error_) / (2 * kPi)};
  }

 private:
  static constexpr Real kRoundings = 4;  // of the terms' magnitude, that a sum is off
  static constexpr int kDepth = 60;

  struct Piece {
    Sum<Real> sum;
    Real error;  // of the quadrature
  };

  Piece kronrod(const Edge<Real>& e, Real a, Real b) const {
    const Real center = (a + b) / 2, half = (b - a) / 2;
    Piece piece{};
    Real gauss = 0;
    for (std::size_t k = 0; k < kKronrodNode.size(); ++k) {
      const Real node = half * static_cast<Real>(kKronrodNode[k]);
      const Real weight = half * static_cast<Real>(kKronrodWeight[k]);
      for (const Real sign : {Real(-1), Real(1)}) {
        if (node == 0 && sign > 0) continue;
        const Sum<Real> at = integrand(e, center + sign * node);
        piece.sum.value += weight * at.value;
        piece.sum.magnitude += weight * at.magnitude;
        if (k % 2 == 1) gauss += half * static_cast<Real>(kGaussWeight[k / 2]) * at.value;
      }
    }
    piece.error = std::abs(piece.sum.value - gauss);
    return piece;
  }

  Sum<Real> integrand(const Edge<Real>& e, Real s) const {
    const glm::vec<3, Real> x = e.from + s * e.direction;
    Sum<Real> sum;
    for (const Edge<Real>& f : inner_) {
      const Real turn = glm::dot(e.direction, f.direction);
      if (turn == 0) continue;
      const Sum<Real> i = log_integral(x, f);
      sum.value += turn * i.value;
      sum.magnitude += std::abs(turn) * i.magnitude;
    }
    return sum;
  }

  void refine(const Edge<Real>& e, Real a, Real b, int depth) {
    const Piece piece = kronrod(e, a, b);
    if (piece.error <= finest_ || depth == kDepth) {
      value_ += piece.sum.value;
      error_ += piece.error;
      return;
    }
    const Real middle = (a + b) / 2;
    refine(e, a, middle, depth + 1);
    refine(e, middle, b, depth + 1);
  }

  std::vector<Edge<Real>> outer_, inner_;
  Real finest_ = 0;  // what rounding leaves to be gained
  Real value_ = 0, error_ = 0;
};

// ---- cubature

class PairCubature {
 public:
  PairCubature(const Plane& p1, const Plane& p2) : p1_(p1), p2_(p2) {}

  Estimate integrate(std::span<const Triangle> t1, std::span<const Triangle> t2) {
    for (const Triangle& a : t1)
      for (const Triangle& b : t2) refine(a, b, 0);
    return sum_;
  }

 private:
  static constexpr double kRelative = 1e-10;
  static constexpr double kNegligible = 1e-12;
  static constexpr int kDepth = 40;
  static constexpr int kPairs = 50'000;  // a tenth of a second; then the error says how it is

  template <int kNodes>
  double apply(const Triangle& a, const Triangle& b) const {
    const TriangleRule<kNodes> ra(a), rb(b);
    std::array<double, kNodes * kNodes> above2, above1;
    for (std::size_t i = 0; i < ra.at.size(); ++i)
      above2[i] = ra.weight[i] * std::max(0.0, p2_.distance(ra.at[i]));
    for (std::size_t j = 0; j < rb.at.size(); ++j)
      above1[j] = rb.weight[j] * std::max(0.0, p1_.distance(rb.at[j]));
    double sum = 0;
    for (std::size_t i = 0; i < ra.at.size(); ++i) {
      double row = 0;
      for (std::size_t j = 0; j < rb.at.size(); ++j) {
        const Vec3 r = rb.at[j] - ra.at[i];
        const double r2 = dot(r, r);
        row += above1[j] / (r2 * r2);
      }
      sum += above2[i] * row;
    }
    return sum * area(a) * area(b) / kPi;
  }

  void refine(const Triangle& a, const Triangle& b, int depth) {
    ++pairs_;
    const double coarse = apply<3>(a, b);
    const double fine = apply<5>(a, b);
    const double error = error_of_finer(coarse, fine);
    if (error <= kRelative * fine || error <= kNegligible * sum_.value || depth == kDepth ||
        pairs_ >= kPairs) {
      sum_.value += fine;
      sum_.error += error;
      return;
    }
    const bool first = longest_edge(a) >= longest_edge(b);
    const auto [s, t] = bisect(first ? a : b);
    for (const Triangle& half : {s, t})
      first ? refine(half, b, depth + 1) : refine(a, half, depth + 1);
  }

  Plane p1_, p2_;
  Estimate sum_;
  int pairs_ = 0;
};

// ---- polygons

// Distances below this many roundings of the largest coordinate are none.
constexpr double kNoise = 8;

double largest_coordinate(PolygonView polygon) {
  double largest = 0;
  for (const Vec3& x : polygon)
    largest = std::max({largest, std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  return largest;
}

// A1 F12 of the parts in front of each other. Lengths in units of the pair's size.
Result<double> exchange(PolygonView p1, PolygonView p2, double noise) {
  const Plane plane1 = plane_of(p1), plane2 = plane_of(p2);
  // Of a concave polygon clip() leaves the parts joined by edges there and back, which cancel.
  const Polygon part1 = clip(p1, plane2, noise), part2 = clip(p2, plane1, noise);
  if (part1.empty() || part2.empty()) return 0.0;
  Estimate contour = Contour<double>(part1, part2).integrate();
  if (contour.good_enough()) return contour.value;
  contour = Contour<long double>(part1, part2).integrate();
  if (contour.good_enough()) return contour.value;

  std::vector<Triangle> t1, t2;
  if (!triangulate(p1, t1)) return Status(Code::kUsage, "polygon 1", "", "crosses itself", "");
  if (!triangulate(p2, t2)) return Status(Code::kUsage, "polygon 2", "", "crosses itself", "");
  const Estimate cubature =
      PairCubature(plane1, plane2).integrate(clip(t1, plane2, noise), clip(t2, plane1, noise));
  return cubature.error < contour.error ? cubature.value : std::max(0.0, contour.value);
}

// Do the segments ab and cd cross inside both?
bool cross_properly(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d, double flat) {
  const auto side = [flat](const Vec2& p, const Vec2& q, const Vec2& x) {
    const double turn = (q.x - p.x) * (x.y - p.y) - (q.y - p.y) * (x.x - p.x);
    return turn > flat ? 1 : turn < -flat ? -1 : 0;
  };
  return side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0;
}

bool crosses_itself(PolygonView polygon, double flat) {
  const Frame frame = frame_of(polygon);
  std::vector<Vec2> p;
  for (const Vec3& x : polygon) p.push_back(frame.to_plane(x));
  const std::size_t n = p.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 2; j < n; ++j)
      if (cross_properly(p[i], p[(i + 1) % n], p[j], p[(j + 1) % n], flat)) return true;
  return false;
}

}  // namespace

Status check_polygon(PolygonView polygon, const std::string& name) {
  const auto refuse = [&name](const char* cause, const char* remedy) {
    return Status(Code::kUsage, name, "", cause, remedy);
  };
  if (polygon.size() < 3) return refuse("has fewer than three corners", "give three or more");
  for (const Vec3& x : polygon)
    if (!std::isfinite(x.x + x.y + x.z)) return refuse("has a corner that is not finite", "");
  const double diameter = bounds(polygon).diagonal();
  const double rounding = kNoise * kEpsilon * largest_coordinate(polygon);
  const double width = area(polygon) / diameter;  // of a rectangle as long
  if (!(diameter > 0) || !(width > rounding)) return refuse("has no area", "");
  constexpr double kPlanar = 1e-6;  // of the width
  if (planarity(polygon) > kPlanar * width + rounding)
    return refuse("is not planar", "cut it into triangles");
  if (crosses_itself(polygon, rounding * diameter))
    return refuse("crosses itself", "cut it into simple polygons");
  return {};
}

Result<PolygonFormFactors> polygon_to_polygon(PolygonView p1, PolygonView p2) {
  ATRIUM_RETURN_IF_ERROR(check_polygon(p1, "polygon 1"));
  ATRIUM_RETURN_IF_ERROR(check_polygon(p2, "polygon 2"));
  // Lengths of the order of one make the logarithms small; the first corner as the origin loses
  // nothing of nearby coordinates.
  Box box = bounds(p1);
  box.extend(bounds(p2));
  const double unit = std::ldexp(1.0, std::ilogb(box.diagonal()));  // so that dividing is exact
  const auto local = [origin = p1[0], unit](PolygonView p) {
    Polygon out;
    for (const Vec3& x : p) out.push_back((x - origin) / unit);
    return out;
  };
  const double noise =
      kNoise * kEpsilon * std::max(largest_coordinate(p1), largest_coordinate(p2)) / unit;
  const Polygon l1 = local(p1), l2 = local(p2);
  const Result<double> a1f12 = exchange(l1, l2, noise);
  if (!a1f12.ok()) return a1f12.status();
  const double f = *a1f12, a1 = area(l1), a2 = area(l2);
  return PolygonFormFactors{f / a1, f / a2, a1 * unit * unit, a2 * unit * unit};
}

}  // namespace atrium
