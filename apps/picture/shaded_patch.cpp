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

// The distance that p lies outside a convex outline, 0 inside.
double outside(std::span<const Vec2> outline, const Vec2& p) {
  double most = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Vec2 edge = outline[(i + 1) % outline.size()] - outline[i];
    const double l = length(edge);
    if (l > 0) most = std::max(most, -cross2(edge, p - outline[i]) / l);
  }
  return most;
}

// Do two patches lie in one plane, lit from one side, with one paint?
bool one_sheet(const PatchHead& a, const PatchHead& b, double tolerance) {
  constexpr double kParallel = 1e-9;  // 1 - cosine
  return a.inert == b.inert && a.reflectance == b.reflectance && a.exitance == b.exitance &&
         dot(a.frame.n, b.frame.n) > 1 - kParallel &&
         std::abs(dot(a.frame.n, b.frame.origin - a.frame.origin)) <= tolerance;
}

// Patches of one plane and one paint, shaded together.
class Sheet {
 public:
  Sheet(const ClusterView& cluster, std::span<const std::size_t> members, double tolerance)
      : frame_(cluster.patch_head(members[0]).frame), tolerance_(tolerance) {
    for (const std::size_t m : members) {
      const PatchView view = cluster.patch(m);
      tolerance_ = std::max(tolerance_, kRounding * view.elements[0].radius);
      Piece piece{m, view, {}, {}, {}};
      for (const Vec2& v : view.vertices) piece.vertices.push_back(to_sheet(view, v));
      for (const Segment2& c : cluster.contacts(m))
        contacts_.push_back({to_sheet(view, c.a), to_sheet(view, c.b)});
      pieces_.push_back(std::move(piece));
    }
  }

  void shade_into(std::vector<ShadedPatch>& patches) {
    for (Piece& piece : pieces_) build_tree(piece);
    for (std::uint32_t p = 0; p < pieces_.size(); ++p)
      for (std::uint32_t f = 0; f < pieces_[p].shaded.faces.size(); ++f) make_corners({p, f});
    for (Piece& piece : pieces_) {
      for (std::size_t f = 0; f < piece.shaded.faces.size(); ++f) make_outline(piece, f);
      patches[piece.member] = std::move(piece.shaded);
    }
  }

 private:
  struct OnOutline {
    double place;  // edge index plus share of the edge
    std::uint32_t corner;
  };
  struct Piece {
    std::size_t member;  // of the cluster's patches
    PatchView view;
    std::vector<Vec2> vertices;  // the view's, in the sheet's frame
    ShadedPatch shaded;
    std::vector<std::vector<OnOutline>> on_outline;  // by face
    std::span<const Vec2> polygon(const Element& e) const {
      return std::span(vertices).subspan(e.first_vertex, e.vertex_count);
    }
    std::span<const Vec2> polygon(std::size_t face) const {
      return polygon(view.elements[shaded.faces[face].element]);
    }
  };
  struct FaceOf {
    std::uint32_t piece, face;
    friend auto operator<=>(const FaceOf&, const FaceOf&) = default;
  };
  struct Group {
    std::vector<bool> sides;  // of the contacts near the corner
    std::vector<FaceOf> faces;
  };

  Vec2 to_sheet(const PatchView& view, const Vec2& p) const {
    return frame_.to_plane(view.point(p));
  }

  // p: in the sheet's frame.
  Spectrum radiosity(const Piece& piece, std::uint32_t element, const Vec2& p) const {
    const PatchHead& head = *piece.view.head;
    const Vec2 own = head.frame.to_plane(frame_.to_space(p));
    const Spectrum e = irradiance_at(piece.view, static_cast<std::int32_t>(element), own);
    return glm::max(head.exitance + head.reflectance * e, Spectrum(0));
  }

  // Leaves become faces, inner elements branches; children stand behind their parents.
  void build_tree(Piece& piece) const {
    const std::span<const Element> elements = piece.view.elements;
    ShadedPatch& shaded = piece.shaded;
    shaded.frame = frame_;
    shaded.emits = luminance(piece.view.head->exitance) > 0;
    std::vector<std::int32_t> node(elements.size());
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const Element& e = elements[i];
      if (!e.leaf()) {
        node[i] = static_cast<std::int32_t>(shaded.branches.size());
        const auto a = static_cast<std::size_t>(e.child);
        shaded.branches.push_back(
            separator(piece.polygon(elements[a]), piece.polygon(elements[a + 1])));
        shaded.branches.back().child = {e.child, e.child + 1};
        continue;
      }
      node[i] = ~static_cast<std::int32_t>(shaded.faces.size());
      const auto element = static_cast<std::uint32_t>(i);
      const Vec2 center = to_sheet(piece.view, e.centroid);
      shaded.faces.push_back(
          {0, 0, e.vertex_count, element, {center, radiosity(piece, element, center)}});
    }
    for (ShadedBranch& b : shaded.branches)
      for (std::int32_t& c : b.child) c = node[static_cast<std::size_t>(c)];
    shaded.root = node[0];
    piece.on_outline.resize(shaded.faces.size());
  }

  // The faces that hold p or come within the tolerance of it, in order.
  void find_faces(const Vec2& p) {
    around_.clear();
    for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
      const Piece& piece = pieces_[i];
      if (outside(piece.polygon(piece.view.elements[0]), p) > tolerance_) continue;
      stack_.assign(1, piece.shaded.root);
      while (!stack_.empty()) {
        const std::int32_t at = stack_.back();
        stack_.pop_back();
        if (at < 0) {
          around_.push_back({i, static_cast<std::uint32_t>(~at)});
          continue;
        }
        const ShadedBranch& b = piece.shaded.branches[static_cast<std::size_t>(at)];
        const double side = dot(b.normal, p) - b.offset;
        if (side <= tolerance_) stack_.push_back(b.child[0]);
        if (side >= -tolerance_) stack_.push_back(b.child[1]);
      }
    }
    std::sort(around_.begin(), around_.end());
  }

  bool has_corner(const FaceOf& f, const Vec2& p) const {
    for (const Vec2& q : pieces_[f.piece].polygon(f.face))
      if (length(p - q) <= tolerance_) return true;
    return false;
  }

  // The corners of a face that no face before it has made.
  void make_corners(const FaceOf& face) {
    for (const Vec2& p : pieces_[face.piece].polygon(face.face)) {
      find_faces(p);
      const bool made = std::any_of(around_.begin(), around_.end(),
                                    [&](const FaceOf& f) { return f < face && has_corner(f, p); });
      if (!made) make_corner(p);
    }
  }

  // One corner for each side of the contacts through p.
  void make_corner(const Vec2& p) {
    near_.clear();
    for (const Segment2& s : contacts_)
      if (distance_to_segment(p, s) <= tolerance_) near_.push_back(s);
    groups_.clear();
    for (const FaceOf& f : around_) {
      const Vec2& inside = pieces_[f.piece].shaded.faces[f.face].center.p;
      std::vector<bool> sides;
      for (const Segment2& s : near_) sides.push_back(cross2(s.b - s.a, inside - s.a) > 0);
      auto group = std::find_if(groups_.begin(), groups_.end(),
                                [&](const Group& g) { return g.sides == sides; });
      if (group == groups_.end()) group = groups_.insert(groups_.end(), {sides, {}});
      group->faces.push_back(f);
    }
    for (const Group& g : groups_) add_corner(p, g.faces);
  }

  // A corner that these faces share; each piece keeps its own copy.
  void add_corner(const Vec2& p, const std::vector<FaceOf>& faces) {
    Spectrum sum(0);
    for (const FaceOf& f : faces) {
      const Piece& piece = pieces_[f.piece];
      sum += radiosity(piece, piece.shaded.faces[f.face].element, p);
    }
    const ShadedCorner corner{p, sum / static_cast<double>(faces.size())};
    for (std::size_t i = 0; i < faces.size(); ++i) {
      Piece& piece = pieces_[faces[i].piece];
      if (i == 0 || faces[i].piece != faces[i - 1].piece) piece.shaded.corners.push_back(corner);
      piece.on_outline[faces[i].face].push_back(
          {place_on_outline(piece.polygon(faces[i].face), p),
           static_cast<std::uint32_t>(piece.shaded.corners.size() - 1)});
    }
  }

  static void make_outline(Piece& piece, std::size_t face) {
    std::vector<OnOutline>& places = piece.on_outline[face];
    std::sort(places.begin(), places.end(), [](const OnOutline& a, const OnOutline& b) {
      return a.place != b.place ? a.place < b.place : a.corner < b.corner;
    });
    ShadedFace& f = piece.shaded.faces[face];
    f.first = static_cast<std::uint32_t>(piece.shaded.outline.size());
    f.count = static_cast<std::uint32_t>(places.size());
    for (const OnOutline& o : places) piece.shaded.outline.push_back(o.corner);
  }

  Frame frame_;
  double tolerance_;
  std::vector<Piece> pieces_;
  std::vector<Segment2> contacts_;
  // Scratch.
  std::vector<FaceOf> around_;
  std::vector<std::int32_t> stack_;
  std::vector<Segment2> near_;
  std::vector<Group> groups_;
};

}  // namespace

std::vector<ShadedPatch> shade(const ClusterView& cluster, double tolerance) {
  std::vector<ShadedPatch> patches(cluster.size());
  std::vector<bool> done(cluster.size());
  for (std::size_t p = 0; p < cluster.size(); ++p) {
    if (done[p]) continue;
    std::vector<std::size_t> members;
    for (std::size_t q = p; q < cluster.size(); ++q)
      if (!done[q] && one_sheet(cluster.patch_head(p), cluster.patch_head(q), tolerance)) {
        members.push_back(q);
        done[q] = true;
      }
    Sheet(cluster, members, tolerance).shade_into(patches);
  }
  return patches;
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
