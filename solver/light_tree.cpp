#include "solver/light_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace atrium {
namespace {

double sine(double cosine) { return std::sqrt(std::max(0.0, 1 - cosine * cosine)); }

// cos and sin of max(0, a - b), both angles in [0, π]. [Pharr, Jakob & Humphreys 2023, 12.6.3]
struct Angle {
  double cosine, sine;
  Angle minus(const Angle& b) const {
    if (cosine > b.cosine) return {1, 0};
    return {cosine * b.cosine + sine * b.sine, sine * b.cosine - cosine * b.sine};
  }
};

// The least cone about two cones' axes and spreads.
struct Cone {
  Vec3 axis{0};
  double cos_spread = 1;
};

Cone joined(const Cone& a, const Cone& b) {
  const double spread_a = std::acos(a.cos_spread), spread_b = std::acos(b.cos_spread);
  const double between = std::acos(std::clamp(dot(a.axis, b.axis), -1.0, 1.0));
  const Cone& wide = spread_a >= spread_b ? a : b;
  const Cone& narrow = spread_a >= spread_b ? b : a;
  const double most = std::max(spread_a, spread_b), least = std::min(spread_a, spread_b);
  constexpr double kPi = 3.14159265358979323846;
  if (between + least <= most) return wide;
  const double spread = 0.5 * (most + between + least);
  const Vec3 across = narrow.axis - dot(narrow.axis, wide.axis) * wide.axis;
  if (spread >= kPi || !(length(across) > 0)) return {wide.axis, -1};
  const double turn = spread - most;
  return {normalize(std::cos(turn) * wide.axis + std::sin(turn) * normalize(across)),
          std::cos(spread)};
}

}  // namespace

LightTree::LightTree(std::span<const LightOutline> lights) : leaf_of_light_(lights.size()) {
  if (lights.empty()) return;
  std::vector<std::uint32_t> items(lights.size());
  std::iota(items.begin(), items.end(), 0);
  std::vector<Vec3> centers;
  for (const LightOutline& l : lights) centers.push_back(bounds(l.polygon).center());
  nodes_.reserve(2 * lights.size() - 1);
  build(lights, items, centers, 0);
}

// Halves the items at the median of their longest axis; equal centres go by their numbers.
std::uint32_t LightTree::build(std::span<const LightOutline> lights, std::span<std::uint32_t> items,
                               std::span<const Vec3> centers, std::uint32_t parent) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Box box, spread;
  double power = 0;
  for (const std::uint32_t i : items) {
    box.extend(bounds(lights[i].polygon));
    spread.extend(centers[i]);
    power += lights[i].power;
  }
  Node node;
  node.center = box.center();
  node.radius2 = 0.25 * dot(box.extent(), box.extent());
  node.power = power;
  node.parent = parent;
  nodes_.push_back(node);
  if (items.size() == 1) {
    const LightOutline& light = lights[items[0]];
    nodes_[index].axis = light.axis;
    nodes_[index].mirrored = light.two_sided;
    nodes_[index].light = items[0];
    leaf_of_light_[items[0]] = index;
    return index;
  }
  const Vec3 size = spread.extent();
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::sort(items.begin(), items.end(), [&](std::uint32_t a, std::uint32_t b) {
    const double ca = centers[a][axis], cb = centers[b][axis];
    return ca != cb ? ca < cb : a < b;
  });
  const std::size_t half = items.size() / 2;
  const std::uint32_t first = build(lights, items.first(half), centers, index);
  const std::uint32_t second = build(lights, items.subspan(half), centers, index);
  const auto cone = [&](const Node& n) { return Cone{n.axis, n.mirrored ? -1 : n.cos_spread}; };
  const Cone both = joined(cone(nodes_[first]), cone(nodes_[second]));
  nodes_[index].axis = both.axis;
  nodes_[index].cos_spread = both.cos_spread;
  nodes_[index].next = second;
  return index;
}

double LightTree::importance(const Node& node, const Vec3& x, const Vec3& n) {
  const Vec3 to = node.center - x;
  const double d2 = dot(to, to);
  if (d2 <= node.radius2) return node.power / node.radius2;
  const double share = node.radius2 / d2, inverse = 1 / std::sqrt(d2);
  const Angle ball{std::sqrt(1 - share), std::sqrt(share)};
  const double cos_in = std::clamp(dot(n, to) * inverse, -1.0, 1.0);
  const double arriving = Angle{cos_in, sine(cos_in)}.minus(ball).cosine;
  if (arriving <= 0) return 0;
  double cos_out = std::clamp(-dot(node.axis, to) * inverse, -1.0, 1.0);
  if (node.mirrored) cos_out = std::abs(cos_out);
  const double leaving = Angle{cos_out, sine(cos_out)}
                             .minus({node.cos_spread, sine(node.cos_spread)})
                             .minus(ball)
                             .cosine;
  return leaving <= 0 ? 0 : node.power * arriving * leaving / d2;
}

std::optional<ChosenLight> LightTree::choose(const Vec3& x, const Vec3& n, double u) const {
  if (nodes_.empty()) return std::nullopt;
  std::uint32_t at = 0;
  double probability = 1;
  if (nodes_[0].next == kLeaf && !(importance(nodes_[0], x, n) > 0)) return std::nullopt;
  while (nodes_[at].next != kLeaf) {
    const double a = importance(nodes_[at + 1], x, n),
                 b = importance(nodes_[nodes_[at].next], x, n);
    if (!(a + b > 0)) return std::nullopt;
    const double first = a / (a + b);
    if (u < first) {
      u /= first;
      probability *= first;
      at = at + 1;
    } else {
      u = (u - first) / (1 - first);
      probability *= 1 - first;
      at = nodes_[at].next;
    }
  }
  return ChosenLight{nodes_[at].light, probability};
}

double LightTree::probability(const Vec3& x, const Vec3& n, std::uint32_t light) const {
  std::uint32_t at = leaf_of_light_[light];
  double own = importance(nodes_[at], x, n);
  if (!(own > 0)) return 0;
  double probability = 1;
  while (at != 0) {
    const std::uint32_t parent = nodes_[at].parent;
    const bool first = at == parent + 1;
    const double a = first ? own : importance(nodes_[parent + 1], x, n);
    const double b = first ? importance(nodes_[nodes_[parent].next], x, n) : own;
    if (!(a + b > 0)) return 0;
    probability *= first ? a / (a + b) : 1 - a / (a + b);
    at = parent;
    own = at == 0 ? own : importance(nodes_[at], x, n);
  }
  return probability;
}

}  // namespace atrium
