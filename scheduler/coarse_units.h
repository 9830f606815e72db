// Coarse units: the unknowns of the coarse system (equilibrium.h), of which each is one number a
// channel. A unit is a patch that makes up much of its cluster, a footprint, which is dark where all
// else of its surface is lit (visibility/footprint.h), or the rest of a cluster. Inert
// patches are part of none: they have no light, and would dilute the others'.
//
// Where it pays, large patches are divided into 2^d parts, their places d halvings deep
// (engine/element.h): each is a unit then. The farther down what the coarse system holds, the less
// is left to sweeps. How many parts follows from the model alone.
//
// Invariants:
//  1. A patch's units are consecutive, in the order of their places; those of a cluster too, the
//     rest first.
//  2. Parts have the area of the leaves in them; a leaf that is larger than a part counts with
//     equal shares to the parts that it holds. Before the first gather all are equal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/model.h"
#include "solver/push_pull.h"

namespace atrium {

// Are large patches divided?
enum class Division : std::uint8_t { kNone, kWhereItPays };

// What a gather made of a patch, lm.
struct PatchGain {
  Spectrum gained{0};  // ∫ ΔE dA
  Spectrum beyond{0};  // of gained, what was taken beyond the gather
  std::vector<PlaceGain> places{};  // the same by its places, where it is divided
};

class CoarseUnits {
 public:
  CoarseUnits(const Model& model, Division division);

  std::size_t size() const { return areas_.size(); }
  std::span<const double> areas() const { return areas_; }  // m²
  std::vector<double>& areas() { return areas_; }
  // [first, end) of a cluster.
  std::uint32_t first(ClusterId cluster) const { return first_unit_[cluster.value]; }
  std::uint32_t end(ClusterId cluster) const { return first_unit_[cluster.value + 1]; }
  // By local patch; the first of its parts where it is divided.
  std::span<const std::uint32_t> of(ClusterId cluster) const;
  ClusterId cluster_of(std::size_t unit) const { return ClusterId(cluster_[unit]); }
  // The first part of the patch that it is of; itself where that is not divided.
  std::uint32_t first_part(std::size_t unit) const { return first_part_[unit]; }
  std::size_t parts(std::size_t unit) const { return std::size_t{1} << depth_[unit]; }
  bool divided(std::size_t unit) const { return depth_[unit] > 0; }

  // Slots: for each patch its places down to the parts, for an undivided one the whole of it.
  std::size_t slots(ClusterId cluster) const;
  std::size_t slot(std::uint32_t first_part, std::size_t place) const {
    return first_slot_[first_part] + place_among(2 * parts(first_part), place) - 1;
  }
  // m², by place, down to the parts.
  std::vector<double> place_areas(std::uint32_t first_part) const;
  // What has been gained of a cluster's units; parts get the area that it is of.
  std::vector<PlaceGain> gains(ClusterId cluster, std::span<const PatchGain> patches);
  // Light by unit as it is by patch and place.
  PlacedLight placed(ClusterId cluster, std::span<const Spectrum> by_unit) const;

  std::size_t bytes() const;

 private:
  std::vector<double> areas_;                 // m²
  std::vector<std::uint32_t> unit_of_patch_;  // by PatchId
  std::vector<std::uint32_t> first_patch_;    // by cluster, one more at the end
  std::vector<std::uint32_t> first_unit_;     // by cluster, one more at the end
  std::vector<std::uint32_t> cluster_;        // by unit; so all that follow
  std::vector<std::uint32_t> first_part_;
  std::vector<std::uint32_t> first_slot_;     // of the patch, in its cluster
  std::vector<std::uint8_t> depth_;           // of its place
};

// Entries of K that are to be expected of undivided patches, before there are any links: by the
// pairs of clusters that may see each other.
double undivided_entries(const Model& model);

}  // namespace atrium
