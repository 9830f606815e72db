// Coarse rows: what the links of one receiver make of the coarse system's matrix K (equilibrium.h).
// For each pair of units what they, and the closing of their rows, make of the source's mean
// irradiance in the receiver's: a Galerkin product over functions constant on units. A row must sum
// to what the unit's surroundings reflect, exactly: white rooms live on the small rest of it.
//
// Not thread safe.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "scheduler/coarse_units.h"
#include "solver/link.h"

namespace atrium {

// What K holds of one receiving unit.
struct CoarseEntry {
  std::uint32_t unit = 0;                // the source
  std::array<float, kChannels> share{};  // of the source's mean E, in the receiver's
  float form_factor = 0;                 // of the source's mean B: what share is without its paint
};

inline Spectrum share_of(const CoarseEntry& e) { return {e.share[0], e.share[1], e.share[2]}; }

// Sums the rows of one receiver while its links are made, source by source.
class CoarseRows {
 public:
  CoarseRows(const CoarseUnits& units, ClusterId receiver);
  ClusterId receiver() const { return receiver_; }
  // The braid's sources come in ascending order.
  void add(const Braid& braid, const ClusterView& source, std::span<const PatchTree> receiver,
           const GroupView& groups = {});
  // How a patch's row is closed: after all sources.
  void close(std::size_t patch, const PatchTree& tree, const Closing& closing);
  // Of a unit of the receiver, when all are closed and its areas are those of its leaves; sources
  // ascend.
  std::vector<CoarseEntry> row(std::uint32_t unit) const;

 private:
  // Sums over links, m² × the source's reflectance: in float, white rows would miss what they
  // absorb.
  struct Entry {
    std::uint32_t unit = 0;
    Spectrum share{0}, doubt{0};     // of form factors, and their variances
    double factors = 0, doubts = 0;  // m², the same of a source that reflects all
    bool none() const { return factors == 0 && doubts == 0; }
    void add(double by, const Entry& e);
  };
  // Of an undivided unit, or of a place of a divided patch as far as elements receive that are no
  // smaller.
  struct Row {
    std::vector<Entry> entries;                    // by source unit, ascending; not closed
    double doubt = 0;                              // m², of all sources
    double linked = 0, missing = 0, too_much = 0;  // m², Σ form factor × area
    Closing closing;                               // of a divided patch
  };
  void hand_to_units(std::span<Entry> line, ClusterId source, Row& row) const;
  Row row_of_part(std::uint32_t unit) const;
  static void close_part(const Closing& closing, double area, Row& row);

  const CoarseUnits& units_;
  ClusterId receiver_;
  std::vector<Row> rows_;  // by slot
  // Of one braid: lines of slots of its source, those that it has begun.
  std::vector<Entry> block_;
  std::vector<bool> begun_;
};

}  // namespace atrium
