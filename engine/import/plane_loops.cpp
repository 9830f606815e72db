#include "engine/import/plane_loops.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace atrium {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double segment_distance(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double l2 = dot(d, d);
  const double t = l2 > 0 ? std::clamp(dot(p - a, d) / l2, 0.0, 1.0) : 0.0;
  return length(p - (a + t * d));
}

// Points of the rings nearer than `tolerance` to an earlier one (along x) become that one. True if
// any did.
bool merge_near(std::span<const Vec2> points, std::vector<Ring>& rings, double tolerance) {
  std::vector<std::uint32_t> used;
  for (const Ring& ring : rings) used.insert(used.end(), ring.begin(), ring.end());
  std::sort(used.begin(), used.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(points[a].x, a) < std::pair(points[b].x, b);
  });
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::map<std::uint32_t, std::uint32_t> merged;
  for (std::size_t i = 0; i < used.size(); ++i)
    for (std::size_t j = i; j-- > 0;) {
      const Vec2 d = points[used[i]] - points[used[j]];
      if (d.x > tolerance) break;
      if (length(d) > tolerance || merged.contains(used[j])) continue;
      merged[used[i]] = used[j];
      break;
    }
  if (merged.empty()) return false;
  for (Ring& ring : rings) {
    for (std::uint32_t& v : ring)
      if (const auto m = merged.find(v); m != merged.end()) v = m->second;
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    while (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  }
  return true;
}

// Corners of the rings within `tolerance` of an edge are entered into it. True if any were.
bool enter_near(std::span<const Vec2> points, std::vector<Ring>& rings, double tolerance) {
  std::vector<std::uint32_t> used;
  for (const Ring& ring : rings) used.insert(used.end(), ring.begin(), ring.end());
  std::sort(used.begin(), used.end(), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(points[a].x, a) < std::pair(points[b].x, b);
  });
  used.erase(std::unique(used.begin(), used.end()), used.end());
  bool any = false;
  std::vector<std::pair<double, std::uint32_t>> within;
  for (Ring& ring : rings) {
    Ring entered;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::uint32_t a = ring[i], b = ring[(i + 1) % ring.size()];
      const Vec2 p = points[a], q = points[b], d = q - p;
      const double lo = std::min(p.x, q.x) - tolerance, hi = std::max(p.x, q.x) + tolerance;
      entered.push_back(a);
      within.clear();
      auto v = std::partition_point(used.begin(), used.end(),
                                    [&](std::uint32_t u) { return points[u].x < lo; });
      for (; v != used.end() && points[*v].x <= hi; ++v)
        if (*v != a && *v != b && segment_distance(points[*v], p, q) <= tolerance)
          within.push_back({dot(points[*v] - p, d), *v});
      std::sort(within.begin(), within.end());
      for (const auto& [t, u] : within) entered.push_back(u);
      any |= !within.empty();
    }
    ring = std::move(entered);
  }
  return any;
}

}  // namespace

double turn(const Vec2& a, const Vec2& b) {
  const double t = std::atan2(perp(a, b), dot(a, b));
  return t < 0 ? t + 2 * kPi : t;
}

bool names_a_vertex_twice(const Ring& ring) {
  Ring sorted = ring;
  std::sort(sorted.begin(), sorted.end());
  return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

double signed_area(std::span<const Vec2> points, std::span<const std::uint32_t> ring) {
  double sum = 0;
  for (std::size_t i = 2; i < ring.size(); ++i)
    sum += perp(points[ring[i - 1]] - points[ring[0]], points[ring[i]] - points[ring[0]]);
  return 0.5 * sum;
}

Ring without_collinear(std::span<const Vec2> points, const Ring& ring, double tolerance) {
  const std::size_t n = ring.size();
  if (n <= 3) return ring;
  // Start where the outline certainly turns: at the corner farthest from the first one.
  std::size_t start = 0;
  double farthest = -1;
  for (std::size_t i = 0; i < n; ++i) {
    const double d = length(points[ring[i]] - points[ring[0]]);
    if (d > farthest) {
      farthest = d;
      start = i;
    }
  }
  const auto point = [&](std::size_t i) -> const Vec2& { return points[ring[(start + i) % n]]; };
  Ring kept{ring[start]};
  std::size_t anchor = 0;
  for (std::size_t i = 1; i < n; ++i) {
    // Keep corner i unless all since the anchor lie on the way to its successor.
    bool straight = true;
    for (std::size_t j = anchor + 1; j <= i && straight; ++j)
      straight = segment_distance(point(j), point(anchor), point(i + 1)) <= tolerance;
    if (straight) continue;
    kept.push_back(ring[(start + i) % n]);
    anchor = i;
  }
  return kept;
}

std::vector<Ring> cancelled_loops(std::span<const Vec2> points, std::span<const Ring> rings) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::uint32_t a = ring[i], b = ring[(i + 1) % ring.size()];
      if (const auto back = edges.find({b, a}); back != edges.end()) {
        if (--back->second == 0) edges.erase(back);
      } else {
        ++edges[{a, b}];
      }
    }
  std::vector<Ring> loops;
  while (!edges.empty()) {
    Ring loop;
    auto edge = edges.begin();
    const auto [first, second] = edge->first;
    for (;;) {
      const auto [a, b] = edge->first;
      if (--edge->second == 0) edges.erase(edge);
      loop.push_back(a);
      // Where several edges go on, the one that keeps the region on the left: the first one
      // clockwise from the way back. The loop closes when that is the one it began with.
      const auto rank = [&, a = a, b = b](std::uint32_t end) {
        const double t = turn(points[end] - points[b], points[a] - points[b]);
        return t == 0 ? 2 * kPi : t;
      };
      auto best = edges.end();
      double least = b == first ? rank(second) : kInfinity;
      for (auto e = edges.lower_bound({b, 0}); e != edges.end() && e->first.first == b; ++e)
        if (const double t = rank(e->first.second); t < least) {
          least = t;
          best = e;
        }
      if (best == edges.end()) break;
      edge = best;
    }
    if (loop.size() >= 3) loops.push_back(std::move(loop));
  }
  return loops;
}

double perimeter(std::span<const Vec2> points, std::span<const std::uint32_t> ring) {
  double sum = 0;
  for (std::size_t i = 0; i < ring.size(); ++i)
    sum += length(points[ring[(i + 1) % ring.size()]] - points[ring[i]]);
  return sum;
}

std::vector<Ring> healed_loops(std::span<const Vec2> points, std::span<const Ring> rings,
                               double tolerance) {
  std::vector<Ring> healed(rings.begin(), rings.end());
  const bool merged = merge_near(points, healed, tolerance);
  const bool entered = enter_near(points, healed, tolerance);
  std::erase_if(healed, [](const Ring& r) { return r.size() < 3; });
  return merged || entered ? cancelled_loops(points, healed) : healed;
}

}  // namespace atrium
