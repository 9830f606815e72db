#include "apps/picture/shaded_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scheduler/solution.h"

namespace atrium {
namespace {

// Tolerances below this share of the patch's size are rounding.
constexpr double kRounding = 1e-9;

double cross2(const Vec2& a, const Vec2& b) { return a.x * b.y - a.y * b.x; }

double distance_to_segment(const Vec2& p, const Segment2& s) {
  const Vec2 d = s.b - s.a;
  const double length2 = dot(d, d);
  const double t = length2 > 0 ? std::clamp(dot(p - s.a, d) / length2, 0.0, 1.0) : 0;
  return length(p - s.a - t * d);
}

// The line along which two convex neighbours meet: the edge of `a` that has the least of `b`
// inside.
ShadedBranch separator(std::span<const Vec2> a, std::span<const Vec2> b) {
  ShadedBranch best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Vec2 edge = a[(i + 1) % a.size()] - a[i];
    const double l = length(edge);
    if (!(l > 0)) continue;
    const Vec2 outward = Vec2(edge.y, -edge.x) / l;
    const double offset = dot(outward, a[i]);
    double inside = 0;
    for (const Vec2& p : b) inside = std::max(inside, offset - dot(outward, p));
    if (inside < least) least = inside, best.normal = outward, best.offset = offset;
  }
  return best;
}

// Where a corner stands on a leaf's outline: edge index plus the share of that edge.
double place_on_outline(std::span<const Vec2> outline, const Vec2& p) {
  double nearest = std::numeric_limits<double>::infinity(), place = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Segment2 edge{outline[i], outline[(i + 1) % outline.size()]};
    const double away = distance_to_segment(p, edge);
    if (away >= nearest) continue;
    nearest = away;
    const double l = length(edge.b - edge.a);
    place = static_cast<double>(i) + (l > 0 ? std::min(length(p - edge.a) / l, 1.0) : 0);
  }
  return place;
}

class Shader {
 public:
  Shader(const PatchView& patch, std::span<const Segment2> contacts, double tolerance)
      : patch_(patch),
        contacts_(contacts),
        tolerance_(std::max(tolerance, kRounding * patch.elements[0].radius)) {}

  ShadedPatch run() {
    shaded_.frame = patch_.head->frame;
    shaded_.emits = luminance(patch_.head->exitance) > 0;
    build_tree();
    on_outline_.resize(shaded_.faces.size());
    for (std::size_t f = 0; f < shaded_.faces.size(); ++f) make_corners(f);
    for (std::size_t f = 0; f < shaded_.faces.size(); ++f) make_outline(f);
    return std::move(shaded_);
  }

 private:
  struct OnOutline {
    double place;  // edge index plus share of the edge
    std::uint32_t corner;
  };

  std::span<const Vec2> polygon(std::size_t face) const {
    return patch_.polygon(patch_.elements[shaded_.faces[face].element]);
  }

  Spectrum radiosity(std::uint32_t element, const Vec2& p) const {
    const Spectrum e = irradiance_at(patch_, static_cast<std::int32_t>(element), p);
    return glm::max(patch_.head->exitance + patch_.head->reflectance * e, Spectrum(0));
  }

  // Leaves become faces, inner elements branches; children stand behind their parents.
  void build_tree() {
    std::vector<std::int32_t> node(patch_.elements.size());
    for (std::size_t i = 0; i < patch_.elements.size(); ++i) {
      const Element& e = patch_.elements[i];
      if (!e.leaf()) {
        node[i] = static_cast<std::int32_t>(shaded_.branches.size());
        const std::size_t a = static_cast<std::size_t>(e.child);
        shaded_.branches.push_back(
            separator(patch_.polygon(patch_.elements[a]), patch_.polygon(patch_.elements[a + 1])));
        shaded_.branches.back().child = {e.child, e.child + 1};
        continue;
      }
      node[i] = ~static_cast<std::int32_t>(shaded_.faces.size());
      const auto element = static_cast<std::uint32_t>(i);
      shaded_.faces.push_back(
          {0, 0, e.vertex_count, element, {e.centroid, radiosity(element, e.centroid)}});
    }
    for (ShadedBranch& b : shaded_.branches)
      for (std::int32_t& c : b.child) c = node[static_cast<std::size_t>(c)];
    shaded_.root = node[0];
  }

  // The faces that hold p or come within the tolerance of it.
  void find_faces(const Vec2& p) {
    around_.clear();
    stack_.assign(1, shaded_.root);
    while (!stack_.empty()) {
      const std::int32_t at = stack_.back();
      stack_.pop_back();
      if (at < 0) {
        around_.push_back(static_cast<std::uint32_t>(~at));
        continue;
      }
      const ShadedBranch& b = shaded_.branches[static_cast<std::size_t>(at)];
      const double side = dot(b.normal, p) - b.offset;
      if (side <= tolerance_) stack_.push_back(b.child[0]);
      if (side >= -tolerance_) stack_.push_back(b.child[1]);
    }
    std::sort(around_.begin(), around_.end());
  }

  bool has_corner(std::size_t face, const Vec2& p) const {
    for (const Vec2& q : polygon(face))
      if (length(p - q) <= tolerance_) return true;
    return false;
  }

  // The corners of a face that no face before it has made.
  void make_corners(std::size_t face) {
    for (const Vec2& p : polygon(face)) {
      find_faces(p);
      const bool made = std::any_of(around_.begin(), around_.end(),
                                    [&](std::uint32_t f) { return f < face && has_corner(f, p); });
      if (!made) make_corner(p);
    }
  }

  // One corner for each side of the contacts through p.
  void make_corner(const Vec2& p) {
    near_.clear();
    for (const Segment2& s : contacts_)
      if (distance_to_segment(p, s) <= tolerance_) near_.push_back(s);
    groups_.clear();
    for (const std::uint32_t f : around_) {
      const Vec2& inside = shaded_.faces[f].center.p;
      std::vector<bool> sides;
      for (const Segment2& s : near_) sides.push_back(cross2(s.b - s.a, inside - s.a) > 0);
      auto group = std::find_if(groups_.begin(), groups_.end(),
                                [&](const Group& g) { return g.sides == sides; });
      if (group == groups_.end()) group = groups_.insert(groups_.end(), {sides, {}});
      group->faces.push_back(f);
    }
    for (const Group& g : groups_) {
      Spectrum sum(0);
      for (const std::uint32_t f : g.faces) sum += radiosity(shaded_.faces[f].element, p);
      const auto corner = static_cast<std::uint32_t>(shaded_.corners.size());
      shaded_.corners.push_back({p, sum / static_cast<double>(g.faces.size())});
      for (const std::uint32_t f : g.faces)
        on_outline_[f].push_back({place_on_outline(polygon(f), p), corner});
    }
  }

  void make_outline(std::size_t face) {
    std::vector<OnOutline>& places = on_outline_[face];
    std::sort(places.begin(), places.end(), [](const OnOutline& a, const OnOutline& b) {
      return a.place != b.place ? a.place < b.place : a.corner < b.corner;
    });
    ShadedFace& f = shaded_.faces[face];
    f.first = static_cast<std::uint32_t>(shaded_.outline.size());
    f.count = static_cast<std::uint32_t>(places.size());
    for (const OnOutline& o : places) shaded_.outline.push_back(o.corner);
  }

  struct Group {
    std::vector<bool> sides;  // of the contacts near the corner
    std::vector<std::uint32_t> faces;
  };

  const PatchView& patch_;
  std::span<const Segment2> contacts_;
  double tolerance_;
  ShadedPatch shaded_;
  std::vector<std::vector<OnOutline>> on_outline_;  // by face
  std::vector<std::uint32_t> around_;
  std::vector<std::int32_t> stack_;
  std::vector<Segment2> near_;
  std::vector<Group> groups_;
};

}  // namespace

ShadedPatch shade(const PatchView& patch, std::span<const Segment2> contacts, double tolerance) {
  return Shader(patch, contacts, tolerance).run();
}

std::size_t face_at(const ShadedPatch& patch, const Vec2& p) {
  std::int32_t at = patch.root;
  while (at >= 0) {
    const ShadedBranch& b = patch.branches[static_cast<std::size_t>(at)];
    at = b.child[dot(b.normal, p) > b.offset ? 1 : 0];
  }
  return static_cast<std::size_t>(~at);
}

Spectrum radiosity_at(const ShadedPatch& patch, const ShadedFace& face, const Vec2& p) {
  const std::span<const std::uint32_t> outline = patch.outline_of(face);
  const std::size_t n = outline.size();
  const auto corner = [&](std::size_t i) -> const ShadedCorner& {
    return patch.corners[outline[i % n]];
  };
  // [Floater 2003; Hormann & Floater 2006: with the cases of p at a corner and on an edge]
  const double size = length(corner(0).p - face.center.p);
  const double tiny = kRounding * size;
  Spectrum sum(0);
  double weights = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 before = corner(i + n - 1).p - p, here = corner(i).p - p,
               after = corner(i + 1).p - p;
    const double r = length(here);
    if (r <= tiny) return corner(i).radiosity;
    const double area_before = cross2(before, here), area_after = cross2(here, after);
    if (std::abs(area_after) <= tiny * size && dot(here, after) < 0) {
      const double s = length(after);
      return (s * corner(i).radiosity + r * corner(i + 1).radiosity) / (r + s);
    }
    double weight = 0;
    if (area_before != 0) weight += (length(before) - dot(before, here) / r) / area_before;
    if (area_after != 0) weight += (length(after) - dot(here, after) / r) / area_after;
    sum += weight * corner(i).radiosity;
    weights += weight;
  }
  if (!(weights > 0)) return face.center.radiosity;
  return glm::max(sum / weights, Spectrum(0));
}

void append_triangles(const ShadedPatch& patch, std::size_t face,
                      std::vector<std::array<std::uint32_t, 3>>& triangles) {
  const ShadedFace& f = patch.faces[face];
  const std::span<const std::uint32_t> outline = patch.outline_of(f);
  if (f.count < 3) return;
  const bool plain = f.count == f.own;
  const auto center = static_cast<std::uint32_t>(patch.corners.size() + face);
  // A quadrilateral's diagonal joins the two corners that differ less in light.
  std::size_t start = 0;
  if (plain && f.count == 4) {
    const auto light = [&](std::size_t i) {
      return luminance(patch.corners[outline[i]].radiosity);
    };
    start = std::abs(light(1) - light(3)) < std::abs(light(0) - light(2)) ? 1 : 0;
  }
  const std::size_t n = outline.size();
  for (std::size_t i = plain ? 1 : 0; i + (plain ? 1 : 0) < n; ++i) {
    const std::uint32_t apex = plain ? outline[start] : center;
    triangles.push_back({apex, outline[(start + i) % n], outline[(start + i + 1) % n]});
  }
}

}  // namespace atrium
