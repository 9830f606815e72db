#include "visibility/bsp.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <unordered_set>

#include "engine/disjoint_sets.h"
#include "visibility/plane_cluster.h"

namespace atrium {

namespace {

// The grain: the least area of surfaces in a plane worth a split. A share of the diagonal squared,
// of a room or a building, but no more than a share of the surface that has the median of all area:
// a campus is of the grain of its buildings. 0.25 m² in a building of 70 m.
constexpr double kGrainOfDiagonal = 5e-5;
constexpr double kGrainOfMedian = 1.0 / 30;
// Besides having the grain's area, what lies in a plane must cover this share of the node's section
// to be worth a split, or have so many grains, or close a section that is a strip: the hole of a
// stair parts a slab's inside from the air.
constexpr double kMinCoverage = 0.3;
constexpr double kLargeGrains = 60;
// A reveal, in grains: what bounds a hole in a plane that parts space is worth a split however
// little of the section it covers, or the room would join the wall's inside through the hole.
constexpr double kRevealGrains = 0.1;
// Where along an edge it is looked whether it borders a hole, as shares of the edge.
constexpr std::array kAlongEdge{0.25, 0.5, 0.75};
// Splits along reveals stay where they keep dark at least this share of the space they part, or as
// much elsewhere: a niche keeps a wall's inside dark.
constexpr double kDarkShare = 0.25;
// Cells of one room's air that are searched one by one; more of them are one cell again: furniture
// in the open makes portals that all see each other.
constexpr std::size_t kMostCellsOfAir = 32;
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

double grain_of(const Scene& scene) {
  const double diagonal = scene.bounds.diagonal();
  return std::min(kGrainOfDiagonal * diagonal * diagonal,
                  kGrainOfMedian * median_of_area(scene));
}

class Builder {
 public:
  Builder(const Scene& scene, double gap, Bsp& bsp)
      : bsp_(bsp), gap_(gap), diagonal_(scene.bounds.diagonal()), center_(scene.bounds.center()) {
    min_area_ = grain_of(scene);
    reveal_area_ = kRevealGrains * min_area_;
    large_area_ = kLargeGrains * min_area_;
    std::vector<Fragment> fragments;
    PlaneClusters found = cluster_planes(scene, reveal_area_);
    planes_ = std::move(found.planes);
    for (const PlaneClusters::Member& m : found.members) {
      const PolygonView p = scene.polygon(scene.surfaces[m.surface.value]);
      fragments.push_back({m.plane, m.along, Polygon(p.begin(), p.end()), area(p)});
    }
    tally_.resize(planes_.size());
    bsp_.frame = dominant_frame(planes_, center_);
    bsp_.root = build(std::move(fragments), outer_box(scene), false);
  }

 private:
  std::vector<CellFace> outer_box(const Scene& scene) const {
    const Frame& f = bsp_.frame;
    Box box = bounds(scene.vertices, f);
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
      out.push_back(bsp_.frame.to_space(x));
    }
    return out;
  }

  // The plane's frame where it is nearest to the scene's middle.
  Frame middle_of(const CandidatePlane& candidate) const {
    Frame frame = candidate.frame;
    frame.origin = center_ - candidate.plane.distance(center_) * candidate.plane.normal;
    return frame;
  }

  // From a square larger than the scene.
  Polygon section_of(const CandidatePlane& candidate, const std::vector<CellFace>& faces) const {
    const Frame f = middle_of(candidate);
    const double r = 2 * diagonal_;
    return section(faces, f.origin, r * f.u, r * f.v, bsp_.tolerance);
  }

  static constexpr std::uint32_t kNoPlane = ~0u;
  struct Choice {
    std::uint32_t plane = kNoPlane;
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
    const bool is_gap = gap_ > 0 && thickness(faces) <= gap_;
    Choice best;
    double best_score = 0;
    for (std::uint32_t p : here) {
      const double covered = std::max(tally_[p].along, tally_[p].against);
      tally_[p] = {};
      if (covered < min_area_ && !is_gap) continue;
      Polygon cut = section_of(planes_[p], faces);
      const double thin = cut.empty() ? 0 : strip_width(cut);
      if (thin < kSliverTolerances * bsp_.tolerance) continue;
      const double coverage = std::min(1.0, covered / area(cut));
      const double large = std::min(large_area_, thin * thin);
      if (coverage < kMinCoverage && (covered < large || is_gap)) continue;
      const double score = coverage * std::pow(covered, kAreaPower);
      if (score > best_score * (1 + kSameScore)) {
        best_score = score;
        best = {p, std::move(cut)};
      }
    }
    return best;
  }

  // Of a cell: the least distance between one of its faces and the corner farthest from it.
  static double thickness(const std::vector<CellFace>& faces) {
    double least = std::numeric_limits<double>::infinity();
    for (const CellFace& face : faces) {
      double farthest = 0;
      for (const CellFace& other : faces)
        for (const Vec3& x : other.polygon) farthest = std::max(farthest, face.plane.distance(x));
      least = std::min(least, farthest);
    }
    return least;
  }

  // The plane of the largest reveal, if there is one.
  Choice choose_reveal(const std::vector<Fragment>& fragments, const std::vector<CellFace>& faces) {
    Choice best;
    double most = reveal_area_;
    for (const Fragment& f : fragments) {
      if (!(f.area > most * (1 + kSameScore)) || !borders_a_hole(f.polygon, faces)) continue;
      Polygon cut = section_of(planes_[f.plane], faces);
      if (cut.empty() || strip_width(cut) < kSliverTolerances * bsp_.tolerance) continue;
      most = f.area;
      best = {f.plane, std::move(cut)};
    }
    return best;
  }

  // Does an edge of the polygon lie in a face of the cell where the face is open on one side of
  // the edge and opaque on the other?
  bool borders_a_hole(PolygonView polygon, const std::vector<CellFace>& faces) const {
    const double step = 2 * kSliverTolerances * bsp_.tolerance;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
      if (!(length(b - a) > step)) continue;
      for (const CellFace& face : faces) {
        if (face.node == CellFace::kOutside || std::abs(face.plane.distance(a)) > bsp_.tolerance ||
            std::abs(face.plane.distance(b)) > bsp_.tolerance)
          continue;
        const PlaneRegion& opaque = bsp_.nodes[face.node].opaque;
        const Vec3 across = step * normalize(cross(face.plane.normal, b - a));
        for (double t : kAlongEdge) {
          const Vec3 x = a + t * (b - a);
          if (contains(opaque, x + across) != contains(opaque, x - across)) return true;
        }
      }
    }
    return false;
  }

  BspRef add_cell(std::vector<CellFace> faces) {
    bsp_.cells.push_back({std::move(faces)});
    return BspRef::cell(bsp_.cells.size() - 1);
  }

  BspRef build(std::vector<Fragment> fragments, std::vector<CellFace> faces, bool at_reveal) {
    Choice choice = choose(fragments, faces);
    if (choice.plane == kNoPlane) {
      choice = choose_reveal(fragments, faces);
      at_reveal = true;
    }
    if (choice.plane == kNoPlane) return add_cell(std::move(faces));
    const std::size_t index = bsp_.nodes.size();
    const CandidatePlane& candidate = planes_[choice.plane];
    bsp_.nodes.push_back({candidate.plane, {}, {}, std::move(choice.section), {}, false, {}});
    bsp_.nodes[index].at_reveal = at_reveal;
    bsp_.nodes[index].whole = faces;
    std::vector<Fragment> front, back;
    bsp_.nodes[index].opaque = deal(std::move(fragments), candidate, front, back);
    std::vector<CellFace> front_faces, back_faces;
    cut_cell(std::move(faces), index, front_faces, back_faces);
    const BspRef f = build(std::move(front), std::move(front_faces), at_reveal);
    const BspRef b = build(std::move(back), std::move(back_faces), at_reveal);
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
    return union_of({middle_of(candidate), kGridOfTolerance * tolerance}, in_plane,
                    kSliverTolerances * tolerance);
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
  double gap_;  // m
  double diagonal_;
  Vec3 center_;
  double min_area_ = 0, large_area_ = 0, reveal_area_ = 0;  // m²
  std::vector<CandidatePlane> planes_;
  std::vector<PlaneTally> tally_;
};

}  // namespace

Polygon section(const std::vector<CellFace>& faces, const Vec3& middle, const Vec3& u,
                const Vec3& v, double tolerance) {
  Polygon cut{middle - u - v, middle + u - v, middle + u + v, middle - u + v};
  for (const CellFace& face : faces) {
    cut = clip(cut, face.plane, tolerance);
    if (cut.empty()) break;
  }
  return cut;
}

double median_of_area(const Scene& scene) {
  std::vector<double> areas;
  for (const Surface& s : scene.surfaces) areas.push_back(area(scene.polygon(s)));
  std::sort(areas.begin(), areas.end());
  const double half = 0.5 * std::accumulate(areas.begin(), areas.end(), 0.0);
  double sum = 0, median = 0;
  for (std::size_t i = 0; i < areas.size() && sum < half; ++i) sum += median = areas[i];
  return median;
}

Bsp build_bsp(const Scene& scene, double gap) {
  Bsp bsp;
  bsp.tolerance = scene.tolerance;
  Builder(scene, gap, bsp);
  return bsp;
}

namespace {

double volume(const ConvexCell& cell) {
  const Vec3 apex = cell.faces.front().polygon.front();
  double sum = 0;
  for (const CellFace& face : cell.faces)
    sum += area(face.polygon) * std::abs(face.plane.distance(apex)) / 3;
  return sum;
}

// Copies a tree without the splits that part too little.
class Pruner {
 public:
  // dark: of a cell, how much space would be lit with it, m³; nothing if it is lit.
  Pruner(const Bsp& from, const std::vector<double>& dark, std::span<const std::uint32_t> rooms,
         Bsp& to)
      : from_(from), dark_(dark), rooms_(rooms), to_(to), number_(from.nodes.size()) {
    weigh(from.root);
    to_.root = copy(from.root);
  }

 private:
  struct Weight {
    double dark = 0;          // m³, the most that one of its cells keeps so
    double lit = 0, all = 0;  // m³, of itself
    std::uint32_t room = 0;   // of its lit cells
    bool one_room = true;     // they are all of it
    std::size_t lit_cells = 0;
  };

  Weight weigh_cell(std::uint32_t cell) const {
    const double v = volume(from_.cells[cell]);
    if (dark_[cell] > 0) return {dark_[cell], 0, v, 0, true, 0};
    return {0, v, v, rooms_[cell], true, 1};
  }

  static Weight sum(const Weight& f, const Weight& b) {
    const bool both = f.lit_cells > 0 && b.lit_cells > 0;
    return {std::max(f.dark, b.dark),
            f.lit + b.lit,
            f.all + b.all,
            f.lit_cells > 0 ? f.room : b.room,
            f.one_room && b.one_room && !(both && f.room != b.room),
            f.lit_cells + b.lit_cells};
  }

  // Does the split part too little? One along reveals where it keeps too little dark, and all of a
  // crowd of cells in one room's air.
  static bool parts_little(const BspNode& node, const Weight& w) {
    if (w.lit > 0 && w.dark >= kDarkShare * w.all) return false;
    return node.at_reveal || (w.one_room && w.lit_cells > kMostCellsOfAir);
  }

  Weight weigh(BspRef ref) {
    if (ref.is_cell()) return weigh_cell(ref.index());
    const BspNode& node = from_.nodes[ref.index()];
    const Weight w = sum(weigh(node.front), weigh(node.back));
    if (!parts_little(node, w)) return w;
    whole_.insert(ref.index());
    return w.lit > 0 ? Weight{0, w.all, w.all, w.room, w.one_room, w.lit_cells} : w;
  }

  BspRef copy(BspRef ref) {
    if (ref.is_cell()) return add_cell(from_.cells[ref.index()].faces);
    const BspNode& node = from_.nodes[ref.index()];
    if (whole_.contains(ref.index())) return add_cell(node.whole);
    const std::size_t index = number_[ref.index()] = to_.nodes.size();
    to_.nodes.push_back({node.plane, {}, {}, node.section, node.opaque, false, {}});
    const BspRef front = copy(node.front), back = copy(node.back);
    to_.nodes[index].front = front;
    to_.nodes[index].back = back;
    return BspRef::node(index);
  }

  BspRef add_cell(std::vector<CellFace> faces) {
    for (CellFace& face : faces)
      if (face.node != CellFace::kOutside)
        face.node = static_cast<std::uint32_t>(number_[face.node]);
    to_.cells.push_back({std::move(faces)});
    return BspRef::cell(to_.cells.size() - 1);
  }

  const Bsp& from_;
  const std::vector<double>& dark_;
  std::span<const std::uint32_t> rooms_;
  Bsp& to_;
  std::vector<std::size_t> number_;
  std::unordered_set<std::uint32_t> whole_;
};

}  // namespace

Bsp prune(const Bsp& bsp, std::span<const CellJoint> joints, const std::vector<bool>& lit,
          std::span<const std::uint32_t> rooms) {
  DisjointSets spaces(bsp.cells.size());
  for (const CellJoint& j : joints)
    if (!lit[j.front] && !lit[j.back]) spaces.join(j.front, j.back);
  std::vector<double> dark(bsp.cells.size());
  for (std::size_t c = 0; c < bsp.cells.size(); ++c)
    if (!lit[c]) dark[spaces.find(c)] += volume(bsp.cells[c]);
  for (std::size_t c = 0; c < bsp.cells.size(); ++c)
    if (!lit[c]) dark[c] = dark[spaces.find(c)];
  Bsp pruned;
  pruned.frame = bsp.frame;
  pruned.tolerance = bsp.tolerance;
  Pruner(bsp, dark, rooms, pruned);
  return pruned;
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
