#include "visibility/contact.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "visibility/bsp.h"

namespace atrium {

namespace {

// The part of `line` at least `inset` within every edge of the convex polygon.
std::optional<Contact> clip_inside(PolygonView polygon, const Vec3& normal, const Contact& line,
                                   double inset) {
  double from = 0, to = 1;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 edge = polygon[(i + 1) % polygon.size()] - polygon[i];
    const double l = length(edge);
    if (!(l > 0)) continue;
    const Vec3 inward = cross(normal, edge) / l;
    const double a = dot(inward, line.a - polygon[i]) - inset;
    const double b = dot(inward, line.b - polygon[i]) - inset;
    if (a < 0 && b < 0) return {};
    if (a < 0) from = std::max(from, a / (a - b));
    if (b < 0) to = std::min(to, a / (a - b));
  }
  const Vec3 d = line.b - line.a;
  if (!((to - from) * length(d) > inset)) return {};
  return Contact{line.a + from * d, line.a + to * d};
}

// A surface hovers over a plane where all of it is in front, nearer than this share of its size: a
// lamp's panel below a ceiling, a sign on a wall.
constexpr double kHover = 0.1;

bool hovers(PolygonView polygon, const Plane& plane, double tolerance) {
  const double reach = kHover * bounds(polygon).diagonal();
  for (const Vec3& x : polygon) {
    const double d = plane.distance(x);
    if (d <= tolerance || d > reach) return false;
  }
  return true;
}

// Its outline, seen along the plane's normal: what it lights or shades below it ends there.
void add_outline(PolygonView hovering, PolygonView polygon, const Plane& plane, double inset,
                 std::vector<Contact>& out) {
  const auto down = [&](const Vec3& x) { return x - plane.distance(x) * plane.normal; };
  for (std::size_t i = 0; i < hovering.size(); ++i) {
    const Contact edge{down(hovering[i]), down(hovering[(i + 1) % hovering.size()])};
    if (const auto inside = clip_inside(polygon, plane.normal, edge, inset)) out.push_back(*inside);
  }
}

// Merges segments that overlap on one line, within tolerance.
std::vector<Contact> merge(std::vector<Contact> segments, double tolerance) {
  std::stable_sort(segments.begin(), segments.end(), [](const Contact& s, const Contact& t) {
    return length(s.b - s.a) > length(t.b - t.a);
  });
  std::vector<Contact> kept;
  for (Contact s : segments) {
    bool grown = true;
    while (grown) {
      grown = false;
      for (std::size_t k = 0; k < kept.size(); ++k) {
        Contact& longer = length(kept[k].b - kept[k].a) >= length(s.b - s.a) ? kept[k] : s;
        Contact& other = &longer == &s ? kept[k] : s;
        const double l = length(longer.b - longer.a);
        const Vec3 u = (longer.b - longer.a) / l;
        auto off_line = [&](const Vec3& x) { return length(cross(x - longer.a, u)); };
        if (off_line(other.a) > tolerance || off_line(other.b) > tolerance) continue;
        double from = dot(other.a - longer.a, u), to = dot(other.b - longer.a, u);
        if (from > to) std::swap(from, to);
        if (from > l + tolerance || to < -tolerance) continue;
        s = {longer.a + std::min(0.0, from) * u, longer.a + std::max(l, to) * u};
        kept.erase(kept.begin() + static_cast<std::ptrdiff_t>(k));
        grown = true;
        break;
      }
    }
    kept.push_back(s);
  }
  return kept;
}

}  // namespace

std::optional<Contact> meet(PolygonView polygon, const Plane& plane, double tolerance) {
  double least = 0, most = 0;
  for (const Vec3& x : polygon) {
    const double d = plane.distance(x);
    least = std::min(least, d), most = std::max(most, d);
  }
  if (most <= tolerance) return {};
  // Ends: vertices in the plane, and points where edges cross it. The two farthest apart count.
  std::vector<Vec3> ends;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3 &x = polygon[i], &y = polygon[(i + 1) % polygon.size()];
    const double dx = plane.distance(x), dy = plane.distance(y);
    if (std::abs(dx) <= tolerance) ends.push_back(x - dx * plane.normal);
    if ((dx > tolerance && dy < -tolerance) || (dx < -tolerance && dy > tolerance))
      ends.push_back(x + (y - x) * (dx / (dx - dy)));
  }
  std::optional<Contact> longest;
  double length_of_it = tolerance;
  for (std::size_t i = 0; i < ends.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double l = length(ends[i] - ends[j]);
      if (l > length_of_it) longest = Contact{ends[j], ends[i]}, length_of_it = l;
    }
  return longest;
}

BoxTree surface_tree(const Scene& scene) {
  std::vector<Box> boxes;
  boxes.reserve(scene.surfaces.size());
  for (const Surface& s : scene.surfaces) boxes.push_back(bounds(scene.polygon(s)));
  return BoxTree(std::move(boxes));
}

std::vector<Contact> find_contacts(const Scene& scene, const BoxTree& surfaces,
                                   PolygonView polygon) {
  const Plane plane = plane_of(polygon);
  const double inset = kSliverTolerances * scene.tolerance;
  Box near = bounds(polygon);
  const double reach = scene.tolerance + kHover * near.diagonal();
  near.lo -= Vec3{reach};
  near.hi += Vec3{reach};
  std::vector<std::uint32_t> found;
  surfaces.visit(near, [&](std::uint32_t s) { found.push_back(s); });
  std::sort(found.begin(), found.end());
  std::vector<Contact> segments;
  for (std::uint32_t s : found) {
    const PolygonView other = scene.polygon(scene.surfaces[s]);
    if (hovers(other, plane, scene.tolerance)) add_outline(other, polygon, plane, inset, segments);
    const auto line = meet(other, plane, scene.tolerance);
    if (!line) continue;
    if (const auto inside = clip_inside(polygon, plane.normal, *line, inset))
      segments.push_back(*inside);
  }
  return merge(std::move(segments), inset);
}

}  // namespace atrium
