// LightTree: which of many lights to look at from a point. A binary tree over the lights, walked
// from its root by the importance of each child: its power times what distance and directions let
// through at most. [Conty Estevez & Kulla 2018, Importance Sampling of Many Lights]
//
// Invariants:
//  1. A light that could send anything to a point has a probability above zero there: distances
//     and cosines are bounded over a node's whole ball.
//  2. choose() and probability() agree: what is drawn has the probability that is told.
// Immutable once built; any number of threads may query.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/geometry.h"

namespace atrium {

// A plane polygon that emits, as far as choosing goes.
struct LightOutline {
  PolygonView polygon;
  double power = 0;        // in any unit, above zero
  Vec3 axis{0};            // unit, where it sends
  bool two_sided = false;  // there, and where -axis points
};

struct ChosenLight {
  std::uint32_t light = 0;  // index into what the tree was built on
  double probability = 0;
};

class LightTree {
 public:
  explicit LightTree(std::span<const LightOutline> lights);

  std::size_t size() const { return leaf_of_light_.size(); }

  // From x on a surface with unit normal n; u in (0, 1) decides. None where no light can send
  // anything.
  std::optional<ChosenLight> choose(const Vec3& x, const Vec3& n, double u) const;
  double probability(const Vec3& x, const Vec3& n, std::uint32_t light) const;

 private:
  struct Node {
    Vec3 center{0}, axis{0};
    double radius2 = 0;  // m², of the ball about all its lights
    double power = 0;
    double cos_spread = 1;  // of the cone about `axis` that holds all normals; -1: all directions
    bool mirrored = false;  // a single light that sends along -axis too
    std::uint32_t parent = 0;
    std::uint32_t next = 0;  // its second child, the first comes behind it; kLeaf: it is a light
    std::uint32_t light = 0;
  };
  static constexpr std::uint32_t kLeaf = 0;  // the root is nobody's second child

  std::uint32_t build(std::span<const LightOutline> lights, std::span<std::uint32_t> items,
                      std::span<const Vec3> centers, std::uint32_t parent);
  static double importance(const Node& node, const Vec3& x, const Vec3& n);

  std::vector<Node> nodes_;  // depth first
  std::vector<std::uint32_t> leaf_of_light_;
};

}  // namespace atrium
