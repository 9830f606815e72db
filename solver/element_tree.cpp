#include "solver/element_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "solver/basis.h"
#include "solver/outline.h"
#include "solver/push_pull.h"

namespace atrium {

namespace {

double area_of(const Outline& outline) {
  return outline.size() < 3 ? 0 : moments(outline).area;
}

// Length of the part of a contact inside the element (Cyrus–Beck), 0 if it stays outside.
double length_inside(std::span<const Vec2> outline, const Segment2& s) {
  double t0 = 0, t1 = 1;
  const Vec2 d = s.b - s.a;
  const std::size_t n = outline.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 edge = outline[(i + 1) % n] - outline[i];
    const Vec2 inward{-edge.y, edge.x};
    const double at = dot(inward, s.a - outline[i]), along = dot(inward, d);
    if (along == 0) {
      if (at <= 0) return 0;
      continue;
    }
    const double t = -at / along;
    if (along > 0)
      t0 = std::max(t0, t);
    else
      t1 = std::min(t1, t);
    if (t0 >= t1) return 0;
  }
  return (t1 - t0) * std::hypot(d.x, d.y);
}

// The contact worth splitting along: of those that run along half of their chord of the element or
// more, the longest. Returns the lesser part's share of the area, 0 where there is none.
double contact_line(const PatchTree& tree, const Element& element, Line& line) {
  constexpr double kWorthwhile = 0.5;   // of the chord
  constexpr double kLeastShare = 1e-3;  // of the element's area, for either part
  const std::span<const Vec2> outline = tree.view().polygon(element);
  double best = 0, share = 0;
  for (const Segment2& s : tree.contacts) {
    const double inside = length_inside(outline, s);
    if (inside <= best) continue;
    const Vec2 d = (s.b - s.a) / std::hypot(s.b.x - s.a.x, s.b.y - s.a.y);
    const Vec2 near = s.a + dot(element.centroid - s.a, d) * d, reach = 2 * element.radius * d;
    if (inside < kWorthwhile * length_inside(outline, {near - reach, near + reach})) continue;
    const Line candidate{{-d.y, d.x}, dot(Vec2{-d.y, d.x}, s.a)};
    const std::array<Outline, 2> parts = cut(outline, candidate, 0);
    const double lesser = std::min(area_of(parts[0]), area_of(parts[1])) / element.area;
    if (lesser < kLeastShare) continue;
    if (std::max(parts[0].size(), parts[1].size()) > kMaxOutline) continue;
    best = inside;
    line = candidate;
    share = lesser;
  }
  return share;
}

// Share of the element's area that contacts within it may close off: that of a square with as long
// an outline.
double closed_off(const PatchTree& tree, const Element& element) {
  constexpr double kMost = 0.5;
  const std::span<const Vec2> outline = tree.view().polygon(element);
  double length = 0;
  for (const Segment2& s : tree.contacts) length += length_inside(outline, s);
  return std::min(kMost, length * length / (16 * element.area));
}

// The half of a place that the first or second child of an element there is in.
std::uint16_t half_of(std::uint16_t place, int child) {
  return place < kFirstDeepest ? std::uint16_t(2 * place + child) : place;
}

// Appends an element with its basis; E is left zero.
void append(PatchTree& tree, std::span<const Vec2> outline, std::int32_t parent,
            std::uint16_t place) {
  Element x;
  const Moments m = moments(outline);
  x.area = m.area;
  x.centroid = m.centroid;
  for (const Vec2& p : outline)
    x.radius = std::max(x.radius, std::hypot(p.x - m.centroid.x, p.y - m.centroid.y));
  x.parent = parent;
  x.place = place;
  x.first_vertex = static_cast<std::uint32_t>(tree.vertices.size());
  x.vertex_count = static_cast<std::uint16_t>(outline.size());
  tree.vertices.insert(tree.vertices.end(), outline.begin(), outline.end());
  Line line;
  x.crossing = std::sqrt(contact_line(tree, x, line));
  if (x.crossing == 0) x.crossing = std::sqrt(closed_off(tree, x));
  tree.elements.push_back(x);
  tree.e.resize(tree.e.size() + coefficient_count(tree.order) * kChannels, 0.0);
  tree.basis.resize(tree.basis.size() + triangle_count(tree.order), 0.0);
  const std::size_t i = tree.elements.size() - 1;
  make_basis(outline, x, tree.order,
             std::span(tree.basis).subspan(i * triangle_count(tree.order)));
}

}  // namespace

PatchTree plant(const Model& model, const Scene& scene, PatchId patch, int order) {
  const Patch& p = model.patches[patch.value];
  const PolygonView polygon = model.polygon(p);
  PatchTree tree;
  tree.order = order;
  tree.head.frame = frame_of(polygon);
  tree.head.patch = patch.value;
  tree.head.inert = p.inert;
  if (!p.inert) {
    const Material& m = scene.materials[p.material.value];
    tree.head.reflectance = m.reflectance;
    tree.head.exitance = m.exitance;
  }
  ATRIUM_CHECK(polygon.size() <= kMaxPatchVertices);
  Outline outline;
  for (const Vec3& x : polygon) outline.push_back(tree.head.frame.to_plane(x));
  for (const Contact& c : model.contacts[patch.value])
    tree.contacts.push_back({tree.head.frame.to_plane(c.a), tree.head.frame.to_plane(c.b)});
  append(tree, outline, -1, 1);
  tree.head.area = tree.elements[0].area;
  return tree;
}

bool split_leaf(PatchTree& tree, std::int32_t i, double min_edge) {
  const Element element = tree.elements[i];
  const std::span<const Vec2> outline = tree.view().polygon(element);
  const Extent extent = extent_of(outline);
  const double longer = std::max(extent.hi.x - extent.lo.x, extent.hi.y - extent.lo.y);
  if (longer < 2 * min_edge) return false;
  constexpr double kOnLine = 1e-9;  // of the radius: such a vertex lies on the cut
  Line line;
  if (contact_line(tree, element, line) == 0) line = centroid_line(element.centroid, outline);
  const std::array<Outline, 2> parts = cut(outline, line, kOnLine * element.radius);
  if (!(area_of(parts[0]) > 0) || !(area_of(parts[1]) > 0)) return false;
  for (const Outline& part : parts) {
    const Extent e = extent_of(part);
    if (std::max(e.hi.x - e.lo.x, e.hi.y - e.lo.y) < min_edge) return false;
  }
  if (std::max(parts[0].size(), parts[1].size()) > kMaxOutline) return false;
  const std::int32_t child = static_cast<std::int32_t>(tree.elements.size());
  for (const int half : {0, 1}) append(tree, parts[half], i, half_of(element.place, half));
  tree.elements[i].child = child;
  hand_down(tree, i, child);
  hand_down(tree, i, child + 1);
  return true;
}

}  // namespace atrium
