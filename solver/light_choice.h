// LightChoice: which light a path's vertex looks at. The light tree knows powers and distances, but
// no walls; so a pilot's shadow rays tell, for each small region of surfaces that face about the
// same way, how much each light gave there, and most choices go by that. The tree keeps its share
// everywhere, so that no light is ever beyond reach: what is learnt changes the noise, never the
// mean. [in the manner of Vévoda, Kondapaneni & Křivánek 2018]
//
// Not to be queried while learn() runs; else immutable, and any number of threads may query.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "solver/light_tree.h"

namespace atrium {

// What a light gave at a point, as one sample has it.
struct LightRecord {
  Vec3 x{0}, n{0};
  std::uint32_t light = 0;
  double given = 0;  // in any unit, the same for all
};

class LightChoice {
 public:
  explicit LightChoice(std::span<const LightOutline> lights) : tree_(lights) {}

  // Regions get an edge such that one of surfaces `area` (m²) has enough of the records.
  // Deterministic: records count in their order.
  void learn(std::span<const LightRecord> records, double area);

  // What has been learnt where x lies on a surface with normal n.
  using Region = std::uint32_t;
  Region region(const Vec3& x, const Vec3& n) const;

  std::optional<ChosenLight> choose(Region region, const Vec3& x, const Vec3& n, double u) const;
  double probability(Region region, const Vec3& x, const Vec3& n, std::uint32_t light) const;

 private:
  struct Slot {
    std::uint64_t key = 0;
    std::uint32_t first = 0, count = 0;  // of shares_; none: the slot is free
  };
  struct Share {
    std::uint32_t light = 0;
    double share = 0, before = 0;  // of its region, and of all lights before it there
  };
  std::uint64_t key(const Vec3& x, const Vec3& n) const;
  std::size_t slot_of(std::uint64_t key) const;
  double learnt(Region region, std::uint32_t light) const;

  LightTree tree_;
  Vec3 origin_{0};
  double edge_ = 0;            // m; 0: nothing is learnt
  std::vector<Slot> slots_;    // open addressing
  std::vector<Share> shares_;  // a region's by light
};

}  // namespace atrium
