#include "solver/triangle_cubature.h"

#include <algorithm>

namespace atrium {

namespace {

double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Is the corner `at` of the ring an ear: convex, and nothing of the ring in its triangle?
bool is_ear(std::span<const Vec2> p, const std::vector<std::size_t>& ring, std::size_t at) {
  const std::size_t n = ring.size();
  const Vec2 &a = p[ring[(at + n - 1) % n]], &b = p[ring[at]], &c = p[ring[(at + 1) % n]];
  if (!(turn(a, b, c) > 0)) return false;
  return std::none_of(ring.begin(), ring.end(), [&](std::size_t k) {
    const Vec2& x = p[k];
    if (x == a || x == b || x == c) return false;  // a corner itself, or where a bridge meets it
    return turn(a, b, x) >= 0 && turn(b, c, x) >= 0 && turn(c, a, x) >= 0;
  });
}

// Cuts off nothing: two edges one upon the other.
bool is_flat(std::span<const Vec2> p, const std::vector<std::size_t>& ring, std::size_t at,
             double flat) {
  const std::size_t n = ring.size();
  return std::abs(turn(p[ring[(at + n - 1) % n]], p[ring[at]], p[ring[(at + 1) % n]])) <= flat;
}

}  // namespace

bool triangulate(PolygonView polygon, std::vector<Triangle>& out) {
  const Frame frame = frame_of(polygon);
  std::vector<Vec2> flat_polygon;
  std::vector<std::size_t> ring;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    flat_polygon.push_back(frame.to_plane(polygon[i]));
    ring.push_back(i);
  }
  constexpr double kFlat = 1e-14;  // of the square of the polygon's width
  const Vec3 extent = bounds(polygon).extent();
  const double flat = kFlat * dot(extent, extent);
  while (ring.size() > 2) {
    const std::size_t n = ring.size();
    std::size_t at = 0;
    while (at < n && !is_ear(flat_polygon, ring, at)) ++at;
    if (at < n) {
      out.push_back(
          {polygon[ring[(at + n - 1) % n]], polygon[ring[at]], polygon[ring[(at + 1) % n]]});
    } else {
      for (at = 0; at < n && !is_flat(flat_polygon, ring, at, flat);) ++at;
      if (at == n) return false;
    }
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return true;
}

std::vector<Triangle> clip(std::span<const Triangle> triangles, const Plane& plane,
                           double tolerance) {
  std::vector<Triangle> out;
  for (const Triangle& t : triangles) {
    const Polygon part = clip(PolygonView(t), plane, tolerance);
    for (std::size_t i = 2; i < part.size(); ++i) out.push_back({part[0], part[i - 1], part[i]});
  }
  return out;
}

double area(const Triangle& t) { return 0.5 * length(cross(t[1] - t[0], t[2] - t[0])); }

double longest_edge(const Triangle& t) {
  return std::max({length(t[1] - t[0]), length(t[2] - t[1]), length(t[0] - t[2])});
}

std::pair<Triangle, Triangle> bisect(const Triangle& t) {
  int from = 0;
  double longest = -1;
  for (int i = 0; i < 3; ++i) {
    const Vec3 edge = t[(i + 1) % 3] - t[i];
    const double l = dot(edge, edge);
    if (l > longest) {
      longest = l;
      from = i;
    }
  }
  const Vec3 &a = t[from], &b = t[(from + 1) % 3], &c = t[(from + 2) % 3];
  const Vec3 middle = 0.5 * (a + b);
  return {{a, middle, c}, {middle, b, c}};
}

}  // namespace atrium
