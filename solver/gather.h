// Gather: light across the links of a braid into the receiver's slots. [THFH94 §5.1 step 3(e)]
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine/cluster_record.h"
#include "solver/link.h"
#include "solver/push_pull.h"

namespace atrium {

// What a patch receives in all, and the mean that closes its row. That the row sums to what does not
// leave the scene corrects its links by their share of the doubt, as least squares would.
struct RowMean {
  double form_factors = 0;  // Σ F A, m²
  Spectrum light{0};        // Σ doubt min(B, cap): brighter sources are lamps, not the room
  double weight = 0;        // Σ doubt, m²
};

// What a source cluster sends: of its record, or, where a cluster gathers from itself, of what its
// patches hold by now. It refers to both.
class SourceLight {
 public:
  // pending: lx, by the source's patches: added to their E as it is read. Empty: nothing is.
  // installed: the source's patches, pending included, that are read in the place of the record's.
  SourceLight(const ClusterView& record, std::span<const Spectrum> pending,
              std::span<const PatchTree> installed = {})
      : record_(record), pending_(pending), installed_(installed) {}

  // B = M + ρE, lm/m², coefficient by coefficient; of a group its mean alone.
  std::array<Spectrum, kMaxCoefficients> radiosity(std::uint32_t patch_or_group,
                                                   std::uint32_t element) const;

 private:
  const ClusterView& record_;
  std::span<const Spectrum> pending_;
  std::span<const PatchTree> installed_;
};

// Adds one strand's transfers from `source` to the slots of its receiving patch or group, the
// latter as one element.
// cap: lm/m², luminance above which a source does not count in full in `mean`.
void gather(const Braid& braid, const Braid::Strand& strand, const SourceLight& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean);

}  // namespace atrium
