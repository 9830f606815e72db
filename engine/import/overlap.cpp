#include "engine/import/overlap.h"

#include <algorithm>
#include <cmath>

#include "engine/import/box_tree.h"
#include "engine/import/subtract.h"

namespace atrium {
namespace {

// Cosine of the angle up to which planes may be one: beyond it only slivers lie within tolerance.
constexpr double kSamePlane = 0.99;

struct Claimant {
  Polygon polygon;
  Plane plane;
  Box box;
  bool emits = false;
  // Patches that count instead of this one where they overlap it, by side.
  std::vector<std::uint32_t> over_front, over_back;
};

class Overlaps {
 public:
  Overlaps(const Mesh& mesh, const std::vector<PatchRing>& patches, const RawModel& model,
           Scene& scene, WarningLog& warnings)
      : patches_(patches), model_(model), scene_(scene), warnings_(warnings) {
    claimants_.resize(patches.size());
    for (std::size_t i = 0; i < patches.size(); ++i) {
      Claimant& c = claimants_[i];
      mesh.polygon(patches[i].ring, c.polygon);
      c.plane = plane_of(c.polygon);
      c.box = bounds(c.polygon);
      c.emits = scene.materials[patches[i].material.value].emits();
    }
  }

  void resolve() {
    find();
    for (std::uint32_t i = 0; i < claimants_.size(); ++i) settle(i);
  }

 private:
  double tolerance() const { return scene_.tolerance; }

  void find() {
    std::vector<Box> boxes;
    for (const Claimant& c : claimants_) boxes.push_back(c.box);
    const BoxTree tree(boxes);
    for (std::uint32_t i = 0; i < claimants_.size(); ++i)
      tree.visit(boxes[i], tolerance(), [&](std::uint32_t j) {
        if (i < j && overlap(claimants_[i], claimants_[j])) compete(i, j);
      });
    for (Claimant& c : claimants_) {
      std::sort(c.over_front.begin(), c.over_front.end());
      std::sort(c.over_back.begin(), c.over_back.end());
    }
  }

  // Do the two cover a common part of one plane?
  bool overlap(const Claimant& a, const Claimant& b) const {
    if (std::abs(dot(a.plane.normal, b.plane.normal)) < kSamePlane) return false;
    double lo = HUGE_VAL, hi = -HUGE_VAL;
    for (const Vec3& x : b.polygon) {
      const double d = a.plane.distance(x);
      lo = std::min(lo, d);
      hi = std::max(hi, d);
    }
    if (lo > tolerance() || hi < -tolerance()) return false;
    Polygon common = b.polygon;
    for (std::size_t i = 0; i < a.polygon.size() && !common.empty(); ++i) {
      const Vec3& p = a.polygon[i];
      const Vec3 edge = a.polygon[(i + 1) % a.polygon.size()] - p;
      if (!(length(edge) > 0)) continue;
      const Vec3 inward = normalize(cross(a.plane.normal, edge));
      common = clip(common, {inward, dot(inward, p)}, tolerance());
    }
    if (common.empty() || width(common) <= tolerance()) return false;
    return std::all_of(common.begin(), common.end(),
                       [&](const Vec3& x) { return std::abs(a.plane.distance(x)) <= tolerance(); });
  }

  // Settles who counts where the patches i < j overlap, on either side of their plane.
  void compete(std::uint32_t i, std::uint32_t j) {
    const bool same_way = dot(claimants_[i].plane.normal, claimants_[j].plane.normal) > 0;
    for (const Sides side_of_i : {kFront, kBack}) {
      const Sides side_of_j = (side_of_i == kFront) == same_way ? kFront : kBack;
      if (!(patches_[i].sides & side_of_i) || !(patches_[j].sides & side_of_j)) continue;
      const bool j_counts = side_of_i != side_of_j ? side_of_j == kFront
                                                   : claimants_[j].emits && !claimants_[i].emits;
      if (j_counts)
        lost(i, side_of_i).push_back(j);
      else
        lost(j, side_of_j).push_back(i);
    }
  }

  std::vector<std::uint32_t>& lost(std::uint32_t i, Sides side) {
    return side == kFront ? claimants_[i].over_front : claimants_[i].over_back;
  }

  void settle(std::uint32_t i) {
    const Claimant& c = claimants_[i];
    const std::uint8_t sides = patches_[i].sides;
    const std::size_t before = scene_.surfaces.size();
    if (c.over_front == c.over_back) {
      add_rest(i, c.over_front, sides);
    } else {
      if (sides & kFront) add_rest(i, c.over_front, kFront);
      if (sides & kBack) add_rest(i, c.over_back, kBack);
    }
    if (scene_.surfaces.size() == before) {
      warnings_.add("coplanar faces wholly covered by others, dropped", describe(i));
      return;
    }
    if (!c.over_front.empty())
      warnings_.add("coplanar faces that overlap, the part that does not count cut off",
                    describe(i));
    else if (!c.over_back.empty())
      warnings_.add("backs that lie on other faces, cut off", describe(i));
    ++scene_.patches;
    scene_.lights += c.emits;
  }

  void add_rest(std::uint32_t i, const std::vector<std::uint32_t>& over, std::uint8_t sides) {
    const Claimant& c = claimants_[i];
    if (over.empty()) {
      add(i, c.polygon, sides);
      return;
    }
    others_.clear();
    for (const std::uint32_t j : over) others_.push_back(claimants_[j].polygon);
    for (const Polygon& piece : subtract(c.polygon, others_, tolerance())) add(i, piece, sides);
  }

  void add(std::uint32_t i, const Polygon& polygon, std::uint8_t sides) {
    Surface s;
    s.object = patches_[i].object;
    s.material = patches_[i].material;
    s.sides = sides;
    s.first_vertex = static_cast<std::uint32_t>(scene_.vertices.size());
    s.vertex_count = static_cast<std::uint32_t>(polygon.size());
    scene_.vertices.insert(scene_.vertices.end(), polygon.begin(), polygon.end());
    scene_.surfaces.push_back(s);
  }

  std::string describe(std::uint32_t i) const {
    const Claimant& c = claimants_[i];
    const std::uint32_t over = c.over_front.empty() ? c.over_back.front() : c.over_front.front();
    return model_.describe(model_.faces[patches_[i].raw]) + " under " +
           model_.describe(model_.faces[patches_[over].raw]);
  }

  const std::vector<PatchRing>& patches_;
  const RawModel& model_;
  Scene& scene_;
  WarningLog& warnings_;
  std::vector<Claimant> claimants_;
  std::vector<PolygonView> others_;
};

}  // namespace

void resolve_overlaps(const Mesh& mesh, const std::vector<PatchRing>& patches,
                      const RawModel& model, Scene& scene, WarningLog& warnings) {
  Overlaps(mesh, patches, model, scene, warnings).resolve();
}

}  // namespace atrium
