#include "visibility/bsp.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "visibility/plane_cluster.h"

namespace atrium {

namespace {

// Besides having the grain's area, what lies in a plane must cover this share of the node's section
// to be worth a split, or have this area (a share of the diagonal squared; 15 m² in a building of
// 70 m) or this many grains, or close a section that is a strip: the hole of a stair parts a slab's
// inside from the air.
constexpr double kMinCoverage = 0.3;
constexpr double kLargeArea = 3e-3;
constexpr double kLargeGrains = 5;
// Score: coverage × area to this power. [facts: visibility, step 2]
constexpr double kAreaPower = 0.15;
// Of scores that agree to this the first plane's wins: a turned copy rounds otherwise.
constexpr double kSameScore = 1e-6;
// The outermost cell reaches this share of the diagonal beyond the scene.
constexpr double kMargin = 0.05;

struct Fragment {
  std::uint32_t plane = 0;  // into the candidates
  bool along = true;        // its normal runs along the plane's
  Polygon polygon;
  double area = 0;
};

struct PlaneTally {
  double along = 0, against = 0;  // m²
};

class Builder {
 public:
  Builder(const Scene& scene, double grain, Bsp& bsp)
      : bsp_(bsp), diagonal_(scene.bounds.diagonal()), center_(scene.bounds.center()) {
    min_area_ = grain * diagonal_ * diagonal_;
    large_area_ = std::max(kLargeArea, kLargeGrains * grain) * diagonal_ * diagonal_;
    std::vector<Fragment> fragments;
    PlaneClusters found = cluster_planes(scene, min_area_);
    planes_ = std::move(found.planes);
    for (const PlaneClusters::Member& m : found.members) {
      const PolygonView p = scene.polygon(scene.surfaces[m.surface.value]);
      fragments.push_back({m.plane, m.along, Polygon(p.begin(), p.end()), area(p)});
    }
    tally_.resize(planes_.size());
    bsp_.frame = dominant_frame(planes_, center_);
    bsp_.root = build(std::move(fragments), outer_box(scene));
  }

 private:
  std::vector<CellFace> outer_box(const Scene& scene) const {
    const Frame& f = bsp_.frame;
    Box box;
    for (const Vec3& x : scene.vertices)
      box.extend({dot(x - f.origin, f.u), dot(x - f.origin, f.v), dot(x - f.origin, f.n)});
    box.lo -= Vec3{kMargin * diagonal_};
    box.hi += Vec3{kMargin * diagonal_};
    std::vector<CellFace> faces;
    const Vec3 axis[3] = {f.u, f.v, f.n};
    for (int k = 0; k < 3; ++k)
      for (int upper = 0; upper < 2; ++upper) {
        const Vec3 inward = upper ? -axis[k] : axis[k];
        const double at = upper ? -box.hi[k] : box.lo[k];
        CellFace face;
        face.plane = {inward, dot(inward, f.origin) + at};
        face.polygon = box_face(box, k, upper != 0);
        faces.push_back(std::move(face));
      }
    return faces;
  }

  Polygon box_face(const Box& box, int k, bool upper) const {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    Polygon out;
    for (int corner = 0; corner < 4; ++corner) {
      Vec3 x;
      x[k] = upper ? box.hi[k] : box.lo[k];
      x[i] = corner == 1 || corner == 2 ? box.hi[i] : box.lo[i];
      x[j] = corner >= 2 ? box.hi[j] : box.lo[j];
      const Frame& f = bsp_.frame;
      out.push_back(f.origin + x.x * f.u + x.y * f.v + x.z * f.n);
    }
    return out;
  }

  // The plane's cut through the cell: a square larger than the scene, clipped by the cell's faces.
  Polygon section(const CandidatePlane& candidate, const std::vector<CellFace>& faces) const {
    const Frame& f = candidate.frame;
    const Vec3 middle = center_ - candidate.plane.distance(center_) * candidate.plane.normal;
    const double r = 2 * diagonal_;
    Polygon polygon{middle - r * f.u - r * f.v, middle + r * f.u - r * f.v,
                    middle + r * f.u + r * f.v, middle - r * f.u + r * f.v};
    for (const CellFace& face : faces) {
      polygon = clip(polygon, face.plane, bsp_.tolerance);
      if (polygon.empty()) break;
    }
    return polygon;
  }

  struct Choice {
    std::uint32_t plane = ~0u;
    Polygon section;
  };

  Choice choose(const std::vector<Fragment>& fragments, const std::vector<CellFace>& faces) {
    std::vector<std::uint32_t> here;
    for (const Fragment& f : fragments) {
      PlaneTally& t = tally_[f.plane];
      if (t.along == 0 && t.against == 0) here.push_back(f.plane);
      (f.along ? t.along : t.against) += f.area;
    }
    std::sort(here.begin(), here.end());
    Choice best;
    double best_score = 0;
    for (std::uint32_t p : here) {
      const double covered = std::max(tally_[p].along, tally_[p].against);
      tally_[p] = {};
      if (covered < min_area_) continue;
      Polygon cut = section(planes_[p], faces);
      const double thin = cut.empty() ? 0 : strip_width(cut);
      if (thin < kSliverTolerances * bsp_.tolerance) continue;
      const double coverage = std::min(1.0, covered / area(cut));
      const double large = std::min(large_area_, thin * thin);
      if (coverage < kMinCoverage && covered < large) continue;
      const double score = coverage * std::pow(covered, kAreaPower);
      if (score > best_score * (1 + kSameScore)) {
        best_score = score;
        best = {p, std::move(cut)};
      }
    }
    return best;
  }

  BspRef build(std::vector<Fragment> fragments, std::vector<CellFace> faces) {
    Choice choice = choose(fragments, faces);
    if (choice.plane == ~0u) {
      bsp_.cells.push_back({std::move(faces)});
      return BspRef::cell(bsp_.cells.size() - 1);
    }
    const std::size_t index = bsp_.nodes.size();
    const CandidatePlane& candidate = planes_[choice.plane];
    const Plane plane = candidate.plane;
    bsp_.nodes.push_back({plane, {}, {}, std::move(choice.section), {}});
    std::vector<Fragment> front, back;
    bsp_.nodes[index].opaque = deal(std::move(fragments), candidate, front, back);
    std::vector<CellFace> front_faces, back_faces;
    cut_cell(std::move(faces), index, front_faces, back_faces);
    const BspRef f = build(std::move(front), std::move(front_faces));
    const BspRef b = build(std::move(back), std::move(back_faces));
    bsp_.nodes[index].front = f;
    bsp_.nodes[index].back = b;
    return BspRef::node(index);
  }

  // Fragments in the plane become its opaque union, the others go to their side or are cut.
  PlaneRegion deal(std::vector<Fragment> fragments, const CandidatePlane& candidate,
                   std::vector<Fragment>& front, std::vector<Fragment>& back) const {
    const double tolerance = bsp_.tolerance;
    std::vector<Polygon> in_plane;
    for (Fragment& f : fragments) {
      double least = std::numeric_limits<double>::infinity(), most = -least;
      for (const Vec3& x : f.polygon) {
        const double d = candidate.plane.distance(x);
        least = std::min(least, d), most = std::max(most, d);
      }
      if (most <= tolerance && least >= -tolerance) {
        in_plane.push_back(std::move(f.polygon));
      } else if (least >= -tolerance) {
        front.push_back(std::move(f));
      } else if (most <= tolerance) {
        back.push_back(std::move(f));
      } else {
        Split parts = split(f.polygon, candidate.plane, tolerance);
        auto add = [&f](Polygon polygon, std::vector<Fragment>& to) {
          const double a = area(polygon);
          if (a > 0) to.push_back({f.plane, f.along, std::move(polygon), a});
        };
        add(std::move(parts.front), front);
        add(std::move(parts.back), back);
      }
    }
    Frame frame = candidate.frame;
    frame.origin = center_ - candidate.plane.distance(center_) * candidate.plane.normal;
    return union_of({frame, kGridOfTolerance * tolerance}, in_plane, kSliverTolerances * tolerance);
  }

  void cut_cell(std::vector<CellFace> faces, std::size_t index, std::vector<CellFace>& front,
                std::vector<CellFace>& back) const {
    const BspNode& node = bsp_.nodes[index];
    for (CellFace& face : faces) {
      Split parts = split(face.polygon, node.plane, bsp_.tolerance);
      if (!parts.front.empty()) front.push_back({face.node, face.plane, std::move(parts.front)});
      if (!parts.back.empty()) back.push_back({face.node, face.plane, std::move(parts.back)});
    }
    const auto id = static_cast<std::uint32_t>(index);
    front.push_back({id, node.plane, node.section});
    back.push_back({id, node.plane.flipped(), node.section});
  }

  static constexpr double kGridOfTolerance = 0.1;

  Bsp& bsp_;
  double diagonal_;
  Vec3 center_;
  double min_area_ = 0, large_area_ = 0;  // m²
  std::vector<CandidatePlane> planes_;
  std::vector<PlaneTally> tally_;
};

}  // namespace

Bsp build_bsp(const Scene& scene, double grain) {
  Bsp bsp;
  bsp.tolerance = scene.tolerance;
  Builder(scene, grain, bsp);
  return bsp;
}

DropSide drop_side(const Plane& plane, PolygonView polygon, const Vec3& side, double tolerance) {
  bool front = false, back = false;
  for (const Vec3& x : polygon) {
    const double d = plane.distance(x);
    front |= d > tolerance;
    back |= d < -tolerance;
  }
  if (front && back) return DropSide::kBoth;
  if (!front && !back) return dot(plane.normal, side) > 0 ? DropSide::kFront : DropSide::kBack;
  return front ? DropSide::kFront : DropSide::kBack;
}

Split split_off_slivers(PolygonView polygon, const Plane& plane, double tolerance) {
  Split parts = split(polygon, plane, tolerance);
  const double sliver = kSliverTolerances * tolerance;
  const bool thin_front = parts.front.empty() || strip_width(parts.front) < sliver;
  const bool thin_back = parts.back.empty() || strip_width(parts.back) < sliver;
  const Polygon whole(polygon.begin(), polygon.end());
  if (thin_back && !thin_front) return {whole, {}};
  if (thin_front && !thin_back) return {{}, whole};
  if (thin_front && thin_back)
    return plane.distance(centroid(polygon)) > 0 ? Split{whole, {}} : Split{{}, whole};
  return parts;
}

void drop_polygon(const Bsp& bsp, BspRef from, PolygonView polygon, const Vec3& side,
                  std::vector<CellPiece>& out) {
  if (from.is_cell()) {
    out.push_back({from.index(), Polygon(polygon.begin(), polygon.end())});
    return;
  }
  const BspNode& node = bsp.nodes[from.index()];
  switch (drop_side(node.plane, polygon, side, bsp.tolerance)) {
    case DropSide::kFront:
      return drop_polygon(bsp, node.front, polygon, side, out);
    case DropSide::kBack:
      return drop_polygon(bsp, node.back, polygon, side, out);
    case DropSide::kBoth:
      break;
  }
  const Split parts = split_off_slivers(polygon, node.plane, bsp.tolerance);
  if (!parts.front.empty()) drop_polygon(bsp, node.front, parts.front, side, out);
  if (!parts.back.empty()) drop_polygon(bsp, node.back, parts.back, side, out);
}

}  // namespace atrium
