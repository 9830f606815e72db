#include "solver/coupling.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "engine/squared.h"
#include "solver/form_factor.h"

namespace atrium {

namespace {

// Within this many source radii the four nodes' kernel is no longer within a thousandth of the
// closed form, which is then evaluated.
constexpr double kNear = 4.0;

// Lengths this near each other, relative, are equal: a shifted copy must be probed alike.
constexpr double kTie = 1e-6;
// Nearer to the rim than this share of a site's size, a point is on it.
constexpr double kRim = 1e-6;

double kernel_at(const Vec3& x, const Vec3& nx, const Vec3& y, const Vec3& ny) {
  const Vec3 d = y - x;
  const double cx = dot(nx, d), cy = -dot(ny, d);
  if (cx <= 0 || cy <= 0) return 0;
  const double d2 = dot(d, d);
  return cx * cy / (std::numbers::pi * d2 * d2);
}

// The same of a group's node, which stands for faces of this area: never more than 1.
double kernel_at(const Vec3& x, const Vec3& nx, const Vec3& y, const Vec3& ny, double area) {
  const Vec3 d = y - x;
  const double cx = dot(nx, d), cy = -dot(ny, d);
  if (cx <= 0 || cy <= 0) return 0;
  const double d2 = dot(d, d);
  return cx * cy / (d2 * std::max(std::numbers::pi * d2, area));
}

double fill_row_of_group(const Vec3& x, const Vec3& n, const Site& source,
                         std::array<double, kMaxNodes>& row) {
  double sum = 0;
  for (int l = 0; l < source.nodes; ++l) {
    const double area = source.area * source.weight[l];
    row[l] = area * kernel_at(x, n, source.x[l], source.n[l], area);
    sum += row[l];
  }
  return sum;
}

// One receiver point against all source nodes; returns the row's sum. behind: becomes true where
// none of them is in front, as Kernel has it.
double fill_row(const Vec3& x, const Vec3& n, const Site& source,
                std::array<double, kMaxNodes>& row, bool& behind) {
  if (source.group()) return fill_row_of_group(x, n, source, row);
  double sum = 0;
  for (int l = 0; l < source.nodes; ++l) {
    row[l] = source.area * source.weight[l] * kernel_at(x, n, source.x[l], source.normal);
    sum += row[l];
  }
  const Vec3 d = source.center - x;
  const double near = kNear * source.radius;
  if (dot(d, d) > near * near) return sum;
  const double exact = point_to_polygon_in_sum(x, n, source.polygon());
  behind |= exact > 0 && !(sum > 0);
  for (int l = 0; l < source.nodes; ++l)
    row[l] = sum > 0 ? row[l] * (exact / sum) : exact * source.weight[l];
  return exact;
}

// How far within its rim a point of the site's plane lies, m; not positive outside.
double rim_distance(const Site& site, const Vec3& foot) {
  double least = 2 * site.radius;
  for (int i = 0; i < site.vertices; ++i) {
    const Vec3& a = site.outline[i];
    const Vec3 edge = site.outline[i + 1 < site.vertices ? i + 1 : 0] - a;
    const double l = length(edge);
    if (l > 0) least = std::min(least, dot(cross(site.normal, edge), foot - a) / l);
  }
  return least;
}

// Solves A X = B in place, A symmetric and positive semidefinite; where a function is zero, so is
// its row of X.
void solve_gram(SquareMatrix& a, SquareMatrix& b, int n) {
  constexpr double kNothing = 1e-9;  // of a function's square, which is of the order of 1
  for (int i = 0; i < n; ++i) {
    const double inverse = a[i][i] > kNothing ? 1 / a[i][i] : 0;
    for (int c = 0; c < n; ++c) {
      a[i][c] *= inverse;
      b[i][c] *= inverse;
    }
    for (int r = 0; r < n; ++r) {
      if (r == i) continue;
      const double f = a[r][i];
      for (int c = 0; c < n; ++c) {
        a[r][c] -= f * a[i][c];
        b[r][c] -= f * b[i][c];
      }
    }
  }
}

void add_products(const BasisValues& phi, double weight, int n, SquareMatrix& sum) {
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) sum[a][b] += weight * phi[a] * phi[b];
}

// Means of a value × φ over the part by a least squares fit of the basis to the values at the
// nodes: dual = G C⁻¹ φ with the products' means G over the part and C at the nodes.
void make_dual(const PatchView& patch, std::size_t i, std::span<const Vec2> part,
               const Element& shape, Site& s) {
  const int n = patch.k();
  SquareMatrix exact{}, at_nodes{};
  for (int q = 0; q < s.nodes; ++q) add_products(s.phi[q], s.weight[q], n, at_nodes);
  for_each_product_node(part, shape, patch.order, [&](const Node& node) {
    add_products(evaluate_basis(patch.basis_of(i), patch.elements[i], patch.order, node.p),
                 node.weight, n, exact);
  });
  solve_gram(at_nodes, exact, n);  // C⁻¹ G, the transpose
  s.own_dual = true;
  for (int q = 0; q < s.nodes; ++q) {
    s.dual[q] = {};
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) s.dual[q][a] += exact[b][a] * s.phi[q][b];
  }
}

}  // namespace

Site make_site(const PatchView& patch, std::size_t i, std::span<const Vec2> part) {
  ATRIUM_CHECK(part.size() <= kMaxOutline);
  const Element& e = patch.elements[i];
  const bool whole = part.data() == patch.polygon(e).data();
  Element shape = e;
  if (!whole) {
    const Moments m = moments(part);
    shape.area = m.area;
    shape.centroid = m.centroid;
    shape.radius = 0;
    for (const Vec2& p : part)
      shape.radius = std::max(shape.radius, std::hypot(p.x - m.centroid.x, p.y - m.centroid.y));
  }
  Site s;
  s.normal = patch.head->frame.n;
  s.center = patch.point(shape.centroid);
  s.area = shape.area;
  s.radius = shape.radius;
  s.vertices = static_cast<int>(part.size());
  for (int v = 0; v < s.vertices; ++v) s.outline[v] = patch.point(part[v]);
  const Rule rule = quadrature(part, shape, patch.order);
  s.nodes = rule.count;
  s.cubic_seen = rule.cubic_seen;
  s.bowl = rule.bowl;
  for (int q = 0; q < rule.count; ++q) {
    s.x[q] = patch.point(rule.nodes[q].p);
    s.n[q] = s.normal;
    s.weight[q] = rule.nodes[q].weight;
    s.phi[q] = evaluate_basis(patch.basis_of(i), e, patch.order, rule.nodes[q].p);
  }
  if (!rule.exact_products) make_dual(patch, i, part, shape, s);
  const Rule eyes = patch.order < 3 ? rule : quadrature(part, shape, 2);
  s.eyes = eyes.count;
  for (int q = 0; q < eyes.count; ++q) s.eye[q] = patch.point(eyes.nodes[q].p);
  return s;
}

Vec3 nearest_point(const Site& site, const Vec3& x) {
  const Vec3 foot = x - dot(site.normal, x - site.center) * site.normal;
  if (rim_distance(site, foot) > 0) return foot;
  Vec3 best = foot;
  double best2 = -1;
  for (int i = 0; i < site.vertices; ++i) {
    const Vec3& a = site.outline[i];
    const Vec3 edge = site.outline[i + 1 < site.vertices ? i + 1 : 0] - a;
    const double l2 = dot(edge, edge);
    const Vec3 on = l2 > 0 ? a + std::clamp(dot(foot - a, edge) / l2, 0.0, 1.0) * edge : a;
    const double d2 = dot(on - foot, on - foot);
    if (best2 >= 0 && d2 >= (1 - kTie) * best2) continue;
    best2 = d2;
    best = on;
  }
  return best;
}

namespace {

// Farther away a probe would stand for more than all of the receiver: π > 1.8².
bool close_by(const Site& r, const Site& s) {
  return length(s.center - r.center) < 2.8 * r.radius + s.radius;
}

double factor_at(const Vec3& x, const Site& r, const Site& s) {
  std::array<double, kMaxNodes> unused;
  bool any = false;
  return fill_row(x, r.normal, s, unused, any);
}

// A source above the inside lights a spot of its own size and more, one beside it a strip of the
// rim.
Probe probe_next_to(const Site& r, const Site& s) {
  const double height = dot(r.normal, s.center - r.center);
  const Vec3 foot = s.center - height * r.normal;
  if (rim_distance(r, foot) > kRim * r.radius)
    return {factor_at(foot, r, s), foot, s.area + std::numbers::pi * height * height};
  const Vec3 x = nearest_point(r, s.center);
  return {factor_at(x, r, s), x, length(x - nearest_point(s, x)) * std::sqrt(r.area)};
}

// Its like are the strip along the whole rim, as wide as the gap there.
Probe probe_far_corner(const Site& r, const Site& s) {
  Vec3 far = r.outline[0];
  double perimeter = 0;
  for (int i = 0; i < r.vertices; ++i) {
    const Vec3& v = r.outline[i];
    if (length(v - s.center) > (1 + kTie) * length(far - s.center)) far = v;
    perimeter += length(r.outline[i + 1 < r.vertices ? i + 1 : 0] - v);
  }
  const double gap = length(far - nearest_point(s, far));
  return {factor_at(far, r, s), far, 0.5 * gap * perimeter};
}

}  // namespace

Kernel make_kernel(const Site& receiver, const Site& source) {
  Kernel k;
  k.rows = receiver.nodes;
  k.columns = source.nodes;
  for (int i = 0; i < receiver.nodes; ++i) {
    k.row[i] = fill_row(receiver.x[i], receiver.n[i], source, k.g[i], k.behind);
    k.mean += receiver.weight[i] * k.row[i];
  }
  k.center = k.mean;
  if (receiver.group()) return k;
  k.center = factor_at(receiver.center, receiver, source);
  if (source.group() || !close_by(receiver, source)) return k;
  k.probes = {probe_next_to(receiver, source), probe_far_corner(receiver, source)};
  k.probe_count = 2;
  return k;
}

namespace {

// Weights on a site's nodes that sum to 1 and have the centroid c: exact for what is linear across
// it.
std::array<double, kMaxNodes> weights_about(const Site& site, const Vec3& c) {
  const Vec3 u = normalize(site.outline[1] - site.outline[0]), v = cross(site.normal, u);
  double uu = 0, uv = 0, vv = 0;
  std::array<Vec2, kMaxNodes> at;
  for (int i = 0; i < site.nodes; ++i) {
    const Vec3 d = site.x[i] - site.center;
    at[i] = {dot(d, u), dot(d, v)};
    uu += site.weight[i] * at[i].x * at[i].x;
    uv += site.weight[i] * at[i].x * at[i].y;
    vv += site.weight[i] * at[i].y * at[i].y;
  }
  const Vec2 to{dot(c - site.center, u), dot(c - site.center, v)};
  const double determinant = uu * vv - uv * uv;
  Vec2 slope{0};
  if (determinant > 0) slope = Vec2{vv * to.x - uv * to.y, uu * to.y - uv * to.x} / determinant;
  std::array<double, kMaxNodes> weights{};
  for (int i = 0; i < site.nodes; ++i)
    weights[i] = site.weight[i] * (1 + slope.x * at[i].x + slope.y * at[i].y);
  return weights;
}

// What x sees of a site past blockers.
struct SeenSite {
  bool fits = true;
  bool whole = true;
  double factor = 0;                      // configuration factor, where not the whole is seen
  std::array<double, kMaxNodes> share{};  // of it, by the site's nodes
};

SeenSite seen_site(const Vec3& x, const Vec3& n, const Site& site, const BlockerList& blockers) {
  const Remainder part = seen_part(x, site.polygon(), site.normal, blockers);
  SeenSite seen;
  seen.fits = !part.overflow;
  seen.whole = part.whole;
  if (part.overflow || part.whole) return seen;
  Vec3 moment{0};
  for (const ConvexPiece& piece : std::span(part.pieces).first(part.count)) {
    const double f = point_to_polygon_in_sum(x, n, piece.polygon());
    seen.factor += f;
    moment += f * (centroid(piece.polygon()) - site.center);
  }
  if (seen.factor > 0) seen.share = weights_about(site, site.center + moment / seen.factor);
  return seen;
}

// The rows' sums after their terms have changed. The centre is taken to lose as much as the mean.
void sum_up(const Site& receiver, Kernel& k) {
  const double open = k.mean;
  k.mean = 0;
  for (int i = 0; i < k.rows; ++i) {
    k.row[i] = 0;
    for (int l = 0; l < k.columns; ++l) k.row[i] += k.g[i][l];
    k.mean += receiver.weight[i] * k.row[i];
  }
  if (open > 0) k.center *= k.mean / open;
}

}  // namespace

VisibleMask facing_lanes(const Site& receiver, const Site& source, const Kernel& open) {
  const bool nodes = receiver.looks_from_nodes() && source.looks_from_nodes();
  VisibleMask lanes = 0;
  for (int k = 0; k < receiver.eyes; ++k)
    for (int l = 0; l < source.eyes; ++l) {
      const bool facing =
          nodes ? open.g[k][l] > 0
                : kernel_at(receiver.eye[k], receiver.eye_normal(k), source.eye[l],
                            source.eye_normal(l)) > 0;
      if (facing) lanes |= lane(k, l);
    }
  return lanes;
}

namespace {

// By how much each node sees what each eye does: by the inverse fourth power of the distance.
// [Shepard 68] Rows sum to 1.
using EyeShares = std::array<std::array<double, kMaxEyes>, kMaxNodes>;
EyeShares eye_shares(const Site& site) {
  EyeShares shares{};
  const double least2 = squared(kRim * site.radius);
  for (int i = 0; i < site.nodes; ++i) {
    double sum = 0;
    for (int e = 0; e < site.eyes; ++e) {
      const Vec3 d = site.eye[e] - site.x[i];
      sum += shares[i][e] = 1 / squared(std::max(dot(d, d), least2));
    }
    for (int e = 0; e < site.eyes; ++e) shares[i][e] /= sum;
  }
  return shares;
}

// Share of the segments looked along that get through, as a pair of nodes has them around it.
double seen_about(const std::array<double, kMaxEyes>& from, const std::array<double, kMaxEyes>& to,
                  VisibleMask looked, VisibleMask visible) {
  double all = 0, seen = 0;
  for (int k = 0; k < kMaxEyes; ++k)
    for (int l = 0; l < kMaxEyes; ++l) {
      const double share = from[k] * to[l];
      if (looked & lane(k, l)) all += share;
      if (visible & lane(k, l)) seen += share;
    }
  return all > 0 ? seen / all : 0;
}

}  // namespace

Kernel masked(const Site& receiver, const Site& source, const Kernel& open, VisibleMask looked,
              VisibleMask visible) {
  Kernel out = open;
  if (receiver.looks_from_nodes() && source.looks_from_nodes()) {
    for (int k = 0; k < open.rows; ++k)
      for (int l = 0; l < open.columns; ++l)
        if (!(visible & lane(k, l))) out.g[k][l] = 0;
  } else if (visible != looked) {
    const EyeShares from = eye_shares(receiver), to = eye_shares(source);
    for (int k = 0; k < open.rows; ++k)
      for (int l = 0; l < open.columns; ++l)
        out.g[k][l] *= seen_about(from[k], to[l], looked, visible);
  }
  sum_up(receiver, out);
  return out;
}

std::optional<Kernel> seen_by_receiver(const Site& receiver, const Site& source, const Kernel& open,
                                       const BlockerList& blockers) {
  Kernel out = open;
  for (int k = 0; k < open.rows; ++k) {
    if (!(open.row[k] > 0)) continue;
    const SeenSite seen = seen_site(receiver.x[k], receiver.normal, source, blockers);
    if (!seen.fits) return std::nullopt;
    if (seen.whole) continue;
    const double row = std::min(seen.factor, open.row[k]);
    for (int l = 0; l < open.columns; ++l) out.g[k][l] = row * seen.share[l];
  }
  sum_up(receiver, out);
  const SeenSite from_center = seen_site(receiver.center, receiver.normal, source, blockers);
  if (!from_center.fits) return std::nullopt;
  out.center = from_center.whole ? open.center : std::min(from_center.factor, open.center);
  return out;
}

std::optional<Kernel> seen_by_source(const Site& receiver, const Site& source, const Kernel& open,
                                     const BlockerList& blockers) {
  Kernel out = open;
  for (int l = 0; l < open.columns; ++l) {
    double column = 0;
    for (int k = 0; k < open.rows; ++k) column += receiver.weight[k] * open.g[k][l];
    if (!(column > 0)) continue;
    const SeenSite seen = seen_site(source.x[l], source.normal, receiver, blockers);
    if (!seen.fits) return std::nullopt;
    if (seen.whole) continue;
    const double back = seen.factor * source.weight[l] * source.area / receiver.area;
    for (int k = 0; k < open.rows; ++k)
      out.g[k][l] = std::min(back, column) * seen.share[k] / receiver.weight[k];
  }
  sum_up(receiver, out);
  return out;
}

void couple(const Site& receiver, const Site& source, const Kernel& kernel, int order,
            std::span<float> out) {
  const int n = coefficient_count(order);
  SquareMatrix sum{};
  for (int k = 0; k < kernel.rows; ++k) {
    BasisValues at{};
    for (int l = 0; l < kernel.columns; ++l)
      for (int b = 0; b < n; ++b) at[b] += kernel.g[k][l] * source.test(l)[b];
    for (int a = 0; a < n; ++a)
      for (int b = 0; b < n; ++b) sum[a][b] += receiver.weight[k] * receiver.test(k)[a] * at[b];
  }
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) out[a * n + b] = static_cast<float>(sum[a][b]);
}

}  // namespace atrium
