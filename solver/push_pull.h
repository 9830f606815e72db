// Push and pull over a patch's element tree. [HSA91; THFH94 §5.1 step 4]
//
// A gather leaves on every element what arrived at it across its own links. push_pull hands each
// parent's part down to its children (exact: the child's space holds the parent's), and pulls up
// each parent's E as the L2 projection of its children's. A fourth channel carries the form
// factors: what E would be were every source's radiosity 1.
#pragma once

#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "solver/placed_light.h"

namespace atrium {

inline constexpr int kGatherChannels = kChannels + 1;  // the last: row sum of form factors
inline constexpr int kRowSum = kChannels;

// Of what an element's row may miss, or have too much of, doubts of form factors. [link.h] What no
// ray got through to counts either way: left out where rows are too much, what errors of either sign
// add and take off would not be alike, and an institute lost 2% of its light.
struct DoubtSlot {
  double weight = 0;  // Σ doubt
  Spectrum light{0};  // Σ doubt min(B, cap): brighter sources are lamps, not the room
  void add(const DoubtSlot& s, double by = 1) {
    weight += by * s.weight;
    light += by * s.light;
  }
};

// Gathered coefficients of a tree, elements × K × kGatherChannels, and doubts by element.
struct GatherSlots {
  std::vector<double> g;
  std::vector<DoubtSlot> doubts;
  void reset(std::size_t elements, int k) {
    g.assign(elements * k * kGatherChannels, 0.0);
    doubts.assign(elements, {});
  }
  // New elements start empty.
  void grow(std::size_t elements, int k) {
    g.resize(elements * k * kGatherChannels, 0.0);
    doubts.resize(elements);
  }
};

// What is known of a row beside its links: how much of it must be there, and what stands in for
// what is missing (or too much). [facts: adding the missing form factor times the room's mean
// radiosity halves the time to 1%]
struct Closing {
  enum class How {
    kOpen,        // rows stay as they are
    kEachLeaf,    // nothing leaves the scene: every row sums to 1
    kWholePatch,  // the patch's mean row is made up
    kNoMore,      // links are far too much: no row may sum to more than `whole`
    kNoMoreNorLess,  // the same where nothing leaves the scene: then each is made to sum to 1
  };
  How how = How::kOpen;
  double missing = 0;          // kWholePatch: of the patch's mean row
  double whole = 1;            // kNoMore
  Spectrum mean_radiosity{0};  // lm/m², of what the patch sees, where a leaf has no doubts
};

inline bool too_much(const Closing& c) {
  return c.how == Closing::How::kNoMore || c.how == Closing::How::kNoMoreNorLess;
}

struct PushPullSums {
  double change2 = 0;     // ∫ |ΔB|² dA over leaves, luminance
  double change = 0;      // ∫ |ΔB| dA, of leaf means
  double flux_in = 0;     // ∫ E dA, luminance, lm
  double area = 0;        // m²
  Spectrum gained{0};     // ∫ ΔE dA, lm
  Spectrum beyond{0};     // of it, what was taken beyond the gather
  Spectrum absorbed{0};   // ∫ (1-ρ) E dA
  Spectrum reflected{0};  // ∫ ρ E dA
  Spectrum emitted{0};    // ∫ M dA
  Spectrum escaped{0};    // ∫ B (1 - ΣF) dA over patches that see an opening
  void add(const PushPullSums& s);
};

// What a gather made of a place of a patch, as far as it is of leaves that are no larger.
struct PlaceGain {
  double area = 0;     // m²
  Spectrum gained{0};  // lm, ∫ ΔE dA
  Spectrum beyond{0};  // lm, of it, what was taken beyond the gather
  void add(const PlaceGain& g) {
    area += g.area;
    gained += g.gained;
    beyond += g.beyond;
  }
};

// Replaces the tree's E by what was gathered; `slots` is consumed. over: so many times what the
// gather changes is taken, successive over-relaxation where above 1 [Young 1954], except on leaves
// that would turn negative. change and change2 are the gather's own. gains: of the patch's first
// places, added to; empty: nobody asks.
PushPullSums push_pull(PatchTree& tree, GatherSlots& slots, const Closing& closing,
                       double over = 1, std::span<PlaceGain> gains = {});

// Adds the same E, lx, to all elements.
void add_everywhere(PatchTree& tree, const Spectrum& e);
// To all elements of a patch of a cluster what such light is there.
void add_placed(PatchTree& tree, const PlacedLight& light, std::size_t patch);

// Sets a child's E to its parent's polynomial, expressed in the child's basis.
void hand_down(PatchTree& tree, std::int32_t parent, std::int32_t child);

}  // namespace atrium
