#include "engine/import/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

namespace atrium {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Of the tolerance: up to this far a corner counts as lying on a line or on another corner. Several
// such deviations add up within a piece, which is convex within the whole tolerance.
constexpr double kFineShare = 0.5;
// Two reflex corners for one cut are worth twice the ink.
constexpr double kTwoCornersDiscount = 0.5;
// Cuts ending at a corner make no new point.
constexpr double kCornerDiscount = 0.9;
// How many other corners a corner considers as ends of its cut, nearest first.
constexpr std::size_t kReflexTargets = 8, kOtherTargets = 4;
// A cut that ends nearer to a corner than this share of its length leaves a sliver.
constexpr double kSliverShare = 0.05, kSliverPenalty = 10;

// The planar graph of outlines and cuts.
class Graph {
 public:
  Graph(std::vector<Vec2>& points, std::span<const Ring> loops, double tolerance)
      : points_(points), tolerance_(tolerance) {
    for (const Ring& loop : loops) add_loop(loop);
  }

  // Adds cuts until no sector is reflex; false if a cut finds no end.
  bool cut_all();
  std::vector<Ring> faces() const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;

  struct Node {
    std::uint32_t point = 0;
    std::uint32_t next = kNone, prev = kNone;  // along the outline; none for points of cuts
    std::vector<std::uint32_t> cuts;           // counter-clockwise from `next`
    bool outline() const { return next != kNone; }
  };
  // Where a ray ends: at a node, or within the edge from a to b.
  struct Hit {
    double distance = kInfinity;
    std::uint32_t node = kNone, a = kNone, b = kNone;
    bool found() const { return distance < kInfinity; }
  };
  struct Cut {
    double cost = kInfinity;
    Hit hit;
    Vec2 end{0};
  };

  const Vec2& at(std::uint32_t node) const { return points_[nodes_[node].point]; }
  Vec2 direction(std::uint32_t from, std::uint32_t to) const { return at(to) - at(from); }

  void add_loop(const Ring& loop) {
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    const auto n = static_cast<std::uint32_t>(loop.size());
    for (std::uint32_t i = 0; i < n; ++i)
      nodes_.push_back({loop[i], first + (i + 1) % n, first + (i + n - 1) % n, {}});
  }

  bool is_reflex(std::uint32_t v, std::uint32_t x, std::uint32_t y) const {
    const Vec2 dx = direction(v, x), dy = direction(v, y);
    const double t = turn(dx, dy);
    if (t <= kPi) return false;
    return t >= 1.5 * kPi || std::sin(t - kPi) * std::max(length(dx), length(dy)) > tolerance_;
  }

  // The reflex sector of v, if it has one (at most one is above π).
  bool reflex_sector(std::uint32_t v, std::uint32_t& x, std::uint32_t& y) const {
    if (!nodes_[v].outline()) return false;
    std::uint32_t before = nodes_[v].next;
    for (std::size_t i = 0; i <= nodes_[v].cuts.size(); ++i) {
      const std::uint32_t after = i < nodes_[v].cuts.size() ? nodes_[v].cuts[i] : nodes_[v].prev;
      if (is_reflex(v, before, after)) {
        x = before;
        y = after;
        return true;
      }
      before = after;
    }
    return false;
  }

  // Does the direction d from outline node w lead into the region?
  bool leads_inside(std::uint32_t w, const Vec2& d) const {
    if (!nodes_[w].outline()) return true;
    const Vec2 n = direction(w, nodes_[w].next);
    return turn(n, d) < turn(n, direction(w, nodes_[w].prev));
  }

  Hit shoot(std::uint32_t v, const Vec2& unit) const;
  void meet_edge(std::uint32_t v, const Vec2& unit, std::uint32_t a, std::uint32_t b, Hit& node,
                 Hit& edge) const;
  Cut priced(std::uint32_t v, std::uint32_t x, std::uint32_t y, const Vec2& d) const;
  Cut best_cut(std::uint32_t v) const;
  void targets(std::uint32_t v, std::uint32_t x, std::uint32_t y,
               std::vector<std::uint32_t>& out) const;
  std::uint32_t split_edge(std::uint32_t a, std::uint32_t b, const Vec2& where);
  void insert_cut(std::uint32_t v, std::uint32_t w);
  void apply(std::uint32_t v, const Cut& cut);

  std::vector<Vec2>& points_;
  const double tolerance_;
  std::vector<Node> nodes_;
};

// Enters what the ray from v meets of the edge from a to b: an end within the tolerance of the ray,
// else the crossing.
void Graph::meet_edge(std::uint32_t v, const Vec2& unit, std::uint32_t a, std::uint32_t b,
                      Hit& node, Hit& edge) const {
  if (a == v || b == v) return;
  const Vec2 pa = at(a) - at(v), pb = at(b) - at(v);
  const double sa = perp(unit, pa), sb = perp(unit, pb);
  bool at_end = false;
  const auto meet_end = [&](std::uint32_t w, const Vec2& p, double beside) {
    const double t = dot(unit, p);
    if (std::abs(beside) > tolerance_ || t <= tolerance_ || !leads_inside(w, -p)) return;
    at_end = true;
    if (t < node.distance) node = {t, w, kNone, kNone};
  };
  meet_end(a, pa, sa);
  meet_end(b, pb, sb);
  if (at_end || (sa > 0) == (sb > 0)) return;
  const double t = dot(unit, pa + (pb - pa) * (sa / (sa - sb)));
  if (t > tolerance_ && t < edge.distance) edge = {t, kNone, a, b};
}

// The first outline or cut that a ray from v meets; a corner rather than an edge beside it.
Graph::Hit Graph::shoot(std::uint32_t v, const Vec2& unit) const {
  Hit node, edge;
  for (std::uint32_t a = 0; a < nodes_.size(); ++a) {
    const Node& n = nodes_[a];
    // From inside, an outline's edge is crossed from its left to its right.
    if (n.outline() && perp(direction(a, n.next), unit) <= 0)
      meet_edge(v, unit, a, n.next, node, edge);
    for (const std::uint32_t b : n.cuts)
      if (a < b) meet_edge(v, unit, a, b, node, edge);
  }
  return node.distance <= edge.distance + tolerance_ ? node : edge;
}

Graph::Cut Graph::priced(std::uint32_t v, std::uint32_t x, std::uint32_t y, const Vec2& d) const {
  Cut cut;
  const double l = length(d);
  if (!(l > 0)) return cut;
  const Vec2 unit = d / l;
  cut.hit = shoot(v, unit);
  if (!cut.hit.found() || cut.hit.node == x || cut.hit.node == y) return cut;
  // An end at a corner bends the cut: no new dent may come of it.
  if (cut.hit.node != kNone && (is_reflex(v, x, cut.hit.node) || is_reflex(v, cut.hit.node, y)))
    return cut;
  const auto squareness = [](double angle) { return std::sin(std::min(angle, kPi / 2)); };
  double square =
      std::min(squareness(turn(direction(v, x), unit)), squareness(turn(unit, direction(v, y))));
  double factor = 1;
  if (cut.hit.node != kNone) {
    const std::uint32_t w = cut.hit.node;
    cut.end = at(w);
    factor = kCornerDiscount;
    std::uint32_t wx, wy;
    const Vec2 back = at(v) - at(w);
    if (reflex_sector(w, wx, wy)) {
      const double before = turn(direction(w, wx), back), after = turn(back, direction(w, wy));
      if (before + after < 2 * kPi) {
        square = std::min({square, squareness(before), squareness(after)});
        constexpr double kStraight = kPi + 1e-9;
        if (before <= kStraight && after <= kStraight) factor *= kTwoCornersDiscount;
      }
    } else if (nodes_[w].outline()) {
      square = std::min({square, squareness(turn(direction(w, nodes_[w].next), back)),
                         squareness(turn(back, direction(w, nodes_[w].prev)))});
    }
  } else {
    cut.end = at(v) + cut.hit.distance * unit;
    const Vec2 edge = direction(cut.hit.a, cut.hit.b);
    square = std::min(square, std::abs(perp(edge, unit)) / length(edge));
    const double beside =
        std::min(length(cut.end - at(cut.hit.a)), length(cut.end - at(cut.hit.b)));
    const double share = beside / cut.hit.distance;
    if (share < kSliverShare) factor *= 1 + kSliverPenalty * (1 - share / kSliverShare);
  }
  cut.cost = factor * cut.hit.distance / std::max(square, 1e-12);
  return cut;
}

// Other corners within the directions that resolve the sector of v, nearest first.
void Graph::targets(std::uint32_t v, std::uint32_t x, std::uint32_t y,
                    std::vector<std::uint32_t>& out) const {
  const Vec2 dx = direction(v, x);
  const double sector = turn(dx, direction(v, y));
  std::vector<std::pair<double, std::uint32_t>> reflex, other;
  for (std::uint32_t w = 0; w < nodes_.size(); ++w) {
    if (w == v || w == x || w == y) continue;
    const Vec2 d = direction(v, w);
    const double t = turn(dx, d);
    if (t > kPi || sector - t > kPi || !(dot(d, d) > tolerance_ * tolerance_)) continue;
    std::uint32_t wx, wy;
    (reflex_sector(w, wx, wy) ? reflex : other).push_back({dot(d, d), w});
  }
  out.clear();
  const auto nearest = [&](auto& list, std::size_t most) {
    const std::size_t n = std::min(most, list.size());
    std::partial_sort(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(n), list.end());
    for (std::size_t i = 0; i < n; ++i) out.push_back(list[i].second);
  };
  nearest(reflex, kReflexTargets);
  nearest(other, kOtherTargets);
}

Graph::Cut Graph::best_cut(std::uint32_t v) const {
  Cut best;
  std::uint32_t x, y;
  if (!reflex_sector(v, x, y)) return best;
  const auto consider = [&](const Cut& cut) {
    if (cut.cost < best.cost) best = cut;
  };
  const Vec2 dx = normalize(direction(v, x)), dy = normalize(direction(v, y));
  const double half = 0.5 * turn(dx, dy);
  const Vec2 middle{dx.x * std::cos(half) - dx.y * std::sin(half),
                    dx.x * std::sin(half) + dx.y * std::cos(half)};
  consider(priced(v, x, y, -dx));
  consider(priced(v, x, y, -dy));
  consider(priced(v, x, y, middle));
  std::vector<std::uint32_t> ends;
  targets(v, x, y, ends);
  for (const std::uint32_t w : ends) {
    const Cut cut = priced(v, x, y, direction(v, w));
    if (cut.hit.node == w) consider(cut);
  }
  return best;
}

std::uint32_t Graph::split_edge(std::uint32_t a, std::uint32_t b, const Vec2& where) {
  const auto s = static_cast<std::uint32_t>(nodes_.size());
  points_.push_back(where);
  nodes_.push_back({static_cast<std::uint32_t>(points_.size() - 1), kNone, kNone, {}});
  if (nodes_[a].next == b) {
    nodes_[s].prev = a;
    nodes_[s].next = b;
    nodes_[a].next = nodes_[b].prev = s;
  } else {
    std::replace(nodes_[a].cuts.begin(), nodes_[a].cuts.end(), b, s);
    std::replace(nodes_[b].cuts.begin(), nodes_[b].cuts.end(), a, s);
    nodes_[s].cuts = {a, b};
  }
  return s;
}

// Enters w among the cuts of v, counter-clockwise from `next` (or from the first cut).
void Graph::insert_cut(std::uint32_t v, std::uint32_t w) {
  Node& n = nodes_[v];
  if (n.cuts.empty()) {
    n.cuts.push_back(w);
    return;
  }
  const Vec2 from = direction(v, n.outline() ? n.next : n.cuts.front());
  const double t = turn(from, direction(v, w));
  std::size_t i = n.outline() ? 0 : 1;
  while (i < n.cuts.size() && turn(from, direction(v, n.cuts[i])) < t) ++i;
  n.cuts.insert(n.cuts.begin() + static_cast<std::ptrdiff_t>(i), w);
}

void Graph::apply(std::uint32_t v, const Cut& cut) {
  const std::uint32_t w =
      cut.hit.node != kNone ? cut.hit.node : split_edge(cut.hit.a, cut.hit.b, cut.end);
  insert_cut(v, w);
  insert_cut(w, v);
}

bool Graph::cut_all() {
  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  std::uint32_t x, y;
  for (std::uint32_t v = 0; v < nodes_.size(); ++v)
    if (reflex_sector(v, x, y)) queue.push({0, v});
  while (!queue.empty()) {
    const auto [price, v] = queue.top();
    queue.pop();
    if (!reflex_sector(v, x, y)) continue;
    const Cut cut = best_cut(v);
    if (!(cut.cost < kInfinity)) return false;
    // Prices grow as cuts come between: look again when it is this one's turn.
    if (cut.cost > price * (1 + 1e-9)) {
      queue.push({cut.cost, v});
      continue;
    }
    apply(v, cut);
    if (reflex_sector(v, x, y)) queue.push({0, v});
  }
  return true;
}

std::vector<Ring> Graph::faces() const {
  std::vector<Ring> rings;
  // Directed edges walked, by start node and rank in its fan.
  std::vector<std::vector<char>> walked(nodes_.size());
  const auto ways = [&](std::uint32_t v) {
    return nodes_[v].cuts.size() + (nodes_[v].outline() ? 1 : 0);
  };
  for (std::uint32_t v = 0; v < nodes_.size(); ++v) walked[v].assign(ways(v), 0);
  const auto way = [&](std::uint32_t v, std::size_t rank) {
    if (!nodes_[v].outline()) return nodes_[v].cuts[rank];
    return rank == 0 ? nodes_[v].next : nodes_[v].cuts[rank - 1];
  };
  // The rank of the way out of v that keeps the face on its left, coming from u: the way before
  // the one back to u.
  const auto onward = [&](std::uint32_t u, std::uint32_t v) {
    const Node& n = nodes_[v];
    const auto cut = std::find(n.cuts.begin(), n.cuts.end(), u);
    const auto rank = static_cast<std::size_t>(cut - n.cuts.begin());
    if (!n.outline()) return (rank + n.cuts.size() - 1) % n.cuts.size();
    return rank;  // cuts.size() for prev itself: the last cut, or next where there are no cuts
  };
  for (std::uint32_t start = 0; start < nodes_.size(); ++start)
    for (std::size_t rank = 0; rank < walked[start].size(); ++rank) {
      if (walked[start][rank]) continue;
      Ring ring;
      std::uint32_t v = start;
      std::size_t r = rank;
      while (!walked[v][r]) {
        walked[v][r] = 1;
        ring.push_back(nodes_[v].point);
        const std::uint32_t w = way(v, r);
        r = onward(v, w);
        v = w;
      }
      rings.push_back(std::move(ring));
    }
  return rings;
}

bool is_convex_ring(std::span<const Vec2> points, const Ring& ring, double tolerance) {
  const std::size_t n = ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 a = points[ring[i]], e = points[ring[(i + 1) % n]] - a;
    const double l = length(e);
    for (const std::uint32_t j : ring)
      if (perp(e, points[j] - a) < -tolerance * l) return false;
  }
  return true;
}

}  // namespace

std::optional<std::vector<Ring>> convex_pieces(std::vector<Vec2>& points,
                                               std::span<const Ring> loops, double tolerance,
                                               double area_slack) {
  double area = 0;
  for (const Ring& loop : loops) area += signed_area(points, loop);
  const double fine = kFineShare * tolerance;
  std::vector<Ring> outline;
  std::size_t corners = 0;
  for (const Ring& loop : healed_loops(points, loops, fine)) {
    outline.push_back(without_collinear(points, loop, fine));
    corners += outline.back().size();
    if (outline.back().size() < 3) outline.pop_back();
  }
  if (corners > kMostCorners) return std::nullopt;
  Graph graph(points, outline, fine);
  if (!graph.cut_all()) return std::nullopt;
  std::vector<Ring> pieces;
  double covered = 0;
  for (const Ring& face : graph.faces()) {
    Ring piece = without_collinear(points, face, fine);
    const double a = signed_area(points, piece);
    if (piece.size() < 3 || !(a > fine * fine)) continue;
    if (!is_convex_ring(points, piece, tolerance)) return std::nullopt;
    covered += a;
    pieces.push_back(std::move(piece));
  }
  if (!(std::abs(covered - area) <= area_slack)) return std::nullopt;
  return pieces;
}

}  // namespace atrium
