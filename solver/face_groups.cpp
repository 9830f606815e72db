#include "solver/face_groups.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/squared.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// Normals of a group lie within so much of its axis: the sides of a box are groups of their own, a
// round leg's are few.
constexpr double kWidestCone = std::numbers::pi / 6;
// Below it, relative to what was summed, a mean normal has no direction.
constexpr double kNoDirection = 1e-6;

struct Face {
  std::uint32_t patch = 0;
  Vec3 normal{0}, center{0};
  double area = 0;
};

bool may_be_grouped(const PatchHead& head, double cluster_area) {
  return !head.inert && head.exitance == Spectrum{0} && head.area < kLargeShare * cluster_area;
}

std::vector<Face> small_faces(std::span<const PatchTree> trees) {
  double whole = 0;
  for (const PatchTree& t : trees) whole += t.head.inert ? 0 : t.head.area;
  std::vector<Face> faces;
  for (std::size_t p = 0; p < trees.size(); ++p) {
    const PatchTree& t = trees[p];
    if (may_be_grouped(t.head, whole))
      faces.push_back({std::uint32_t(p), t.head.frame.n,
                       t.head.frame.to_space(t.elements[0].centroid), t.head.area});
  }
  return faces;
}

double angle(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(dot(a, b), -1.0, 1.0)); }

// The area's mean normal; the first face's where they cancel.
Vec3 axis_of(std::span<const Face> faces) {
  Vec3 sum{0};
  double area = 0;
  for (const Face& f : faces) {
    sum += f.area * f.normal;
    area += f.area;
  }
  return length(sum) > kNoDirection * area ? normalize(sum) : faces[0].normal;
}

const Face& farthest(std::span<const Face> faces, const Vec3& from) {
  return *std::min_element(faces.begin(), faces.end(), [&](const Face& a, const Face& b) {
    return dot(a.normal, from) < dot(b.normal, from);
  });
}

class Planter {
 public:
  explicit Planter(std::span<const PatchTree> trees) : trees_(trees) {}

  // Parts by normals until each part is within a cone.
  void plant(std::span<Face> faces) {
    if (faces.size() < 2) return;
    const Vec3 axis = axis_of(faces);
    const Vec3 one = farthest(faces, axis).normal;
    if (angle(one, axis) <= kWidestCone) {
      group(faces);
      return;
    }
    const Vec3 other = farthest(faces, one).normal;
    const auto middle = std::stable_partition(faces.begin(), faces.end(), [&](const Face& f) {
      return dot(f.normal, one) > dot(f.normal, other);
    });
    plant({faces.begin(), middle});
    plant({middle, faces.end()});
  }

  GroupTree take() { return std::move(tree_); }

 private:
  // A group of these, which are two at least, or what stands for one.
  std::int32_t group(std::span<Face> faces, bool inner = false) {
    if (faces.size() == 1) {
      tree_.members.push_back({0, faces[0].patch});
      return ~std::int32_t(faces[0].patch);
    }
    const std::size_t at = tree_.groups.size();
    tree_.groups.push_back(shape_of(faces));
    tree_.groups[at].inner = inner;
    tree_.groups[at].first_member = std::uint32_t(tree_.members.size());
    tree_.groups[at].member_count = std::uint32_t(faces.size());
    const std::size_t half = cut(faces);
    tree_.groups[at].child[0] = group(faces.first(half), true);
    tree_.groups[at].child[1] = group(faces.subspan(half), true);
    return std::int32_t(at);
  }

  // Puts those of one half first and counts them.
  static std::size_t cut(std::span<Face> faces) {
    Box box;
    for (const Face& f : faces) box.extend(f.center);
    const Vec3 extent = box.extent();
    const int along = extent.x >= extent.y && extent.x >= extent.z ? 0
                      : extent.y >= extent.z                       ? 1
                                                                   : 2;
    std::sort(faces.begin(), faces.end(), [&](const Face& a, const Face& b) {
      return a.center[along] != b.center[along] ? a.center[along] < b.center[along]
                                                : a.patch < b.patch;
    });
    return faces.size() / 2;
  }

  FaceGroup shape_of(std::span<const Face> faces) const {
    FaceGroup g;
    g.axis = axis_of(faces);
    Box box;
    for (const Face& f : faces) {
      const PatchTree& t = trees_[f.patch];
      g.area += f.area;
      g.reflectance += f.area * t.head.reflectance;
      g.cone = std::max(g.cone, angle(f.normal, g.axis));
      for (const Vec2& v : t.view().polygon(t.elements[0])) box.extend(t.head.frame.to_space(v));
    }
    g.reflectance /= g.area;
    g.center = box.center();
    for (const Face& f : faces) {
      const PatchTree& t = trees_[f.patch];
      for (const Vec2& v : t.view().polygon(t.elements[0]))
        g.radius = std::max(g.radius, length(t.head.frame.to_space(v) - g.center));
    }
    return g;
  }

  std::span<const PatchTree> trees_;
  GroupTree tree_;
};

// What a patch's light adds to sums over area.
struct LightSums {
  Spectrum radiosity{0};
  double radiosity2 = 0, irradiance = 0, irradiance2 = 0;

  void add(const PatchTree& t) {
    const std::span<const double> e = t.view().e_of(0);
    const double rho = luminance(t.head.reflectance);
    double norm2 = squared(t.elements[0].detail), reflected2 = squared(rho * t.elements[0].detail);
    for (std::size_t a = 0; a < e.size(); a += kChannels) {
      const Spectrum c{e[a], e[a + 1], e[a + 2]};
      norm2 += squared(luminance(c));
      reflected2 += squared(luminance(t.head.reflectance * c));
    }
    const Spectrum mean{e[0], e[1], e[2]};
    radiosity += t.head.area * (t.head.reflectance * mean);
    radiosity2 += t.head.area * reflected2;
    irradiance += t.head.area * luminance(mean);
    irradiance2 += t.head.area * norm2;
  }
};

}  // namespace

GroupTree plant_groups(std::span<const PatchTree> trees, std::size_t least) {
  std::vector<Face> faces = small_faces(trees);
  if (faces.size() < least) return {};
  Planter planter(trees);
  planter.plant(faces);
  GroupTree tree = planter.take();
  double before = 0;
  for (GroupMember& m : tree.members) {
    m.area_before = before;
    before += trees[m.patch].head.area;
  }
  return tree;
}

void pull_groups(std::span<const PatchTree> trees, GroupTree& groups) {
  for (FaceGroup& g : groups.groups) {
    LightSums sums;
    for (const GroupMember& m : groups.view().members_of(g)) sums.add(trees[m.patch]);
    g.radiosity = sums.radiosity / g.area;
    g.irradiance = sums.irradiance / g.area;
    g.detail = std::sqrt(std::max(0.0, sums.radiosity2 / g.area - squared(luminance(g.radiosity))));
    g.irradiance_detail =
        std::sqrt(std::max(0.0, sums.irradiance2 / g.area - squared(g.irradiance)));
  }
}

std::array<std::uint32_t, kGroupNodes> drawn_members(const GroupView& groups, const FaceGroup& g,
                                                     std::uint64_t seed) {
  HashStream dice(seed);
  const std::span<const GroupMember> members = groups.members_of(g);
  std::array<std::uint32_t, kGroupNodes> drawn;
  for (int k = 0; k < kGroupNodes; ++k) {
    const double at = members[0].area_before + (k + dice.uniform()) / kGroupNodes * g.area;
    const auto next =
        std::upper_bound(members.begin() + 1, members.end(), at,
                         [](double area, const GroupMember& m) { return area < m.area_before; });
    drawn[k] = std::prev(next)->patch;
  }
  return drawn;
}

Site make_site(const FaceGroup& g, std::span<const PatchView, kGroupNodes> drawn,
               std::uint64_t seed) {
  constexpr std::uint64_t kPlaces = 1;  // of numbers that have nothing in common with the draw's
  HashStream dice(derived(seed, kPlaces));
  Site s;
  s.nodes = s.eyes = kGroupNodes;
  s.normal = g.axis;
  s.center = g.center;
  s.area = g.area;
  s.radius = g.radius;
  for (int k = 0; k < kGroupNodes; ++k) {
    const PatchView& patch = drawn[k];
    std::array<Vec3, kMaxOutline> outline;
    std::size_t vertices = 0;
    for (const Vec2& v : patch.polygon(patch.elements[0])) outline[vertices++] = patch.point(v);
    const double a = dice.uniform(), b = dice.uniform();
    s.x[k] = point_of(std::span(outline).first(vertices), {a, b});
    s.eye[k] = s.x[k];
    s.n[k] = patch.head->frame.n;
    s.weight[k] = 1.0 / kGroupNodes;
    s.phi[k] = {1};
  }
  return s;
}

void push_groups(const GroupView& groups, std::span<const PatchTree> trees,
                 std::span<GatherSlots> slots, std::span<RowMean> means) {
  for (std::size_t i = 0; i < groups.groups.size(); ++i) {
    const FaceGroup& g = groups.groups[i];
    const std::span<const double> received = std::span(slots[trees.size() + i].g);
    const DoubtSlot doubts = slots[trees.size() + i].doubts[0];
    const RowMean& mean = means[trees.size() + i];
    for (const std::int32_t c : g.child) {
      const std::size_t to = c < 0 ? std::size_t(~c) : trees.size() + std::size_t(c);
      const double share =
          (c < 0 ? trees[to].head.area : groups.groups[std::size_t(c)].area) / g.area;
      for (int n = 0; n < kGatherChannels; ++n) slots[to].g[n] += received[n];
      slots[to].doubts[0].add(doubts);
      means[to].form_factors += share * mean.form_factors;
      means[to].doubts.add(mean.doubts, share);
    }
  }
}

}  // namespace atrium
