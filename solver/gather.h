// Gather: light across the links of a braid into the receiver's slots. [THFH94 §5.1 step 3(e)]
#pragma once

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

// Adds one strand's transfers from `source` to the slots of its receiving patch or group, the latter
// as one element.
// pending: lx, by the source's patches: added to their E as it is read. Empty: nothing is.
// cap: lm/m², luminance above which a source does not count in full in `mean`.
void gather(const Braid& braid, const Braid::Strand& strand, const ClusterView& source,
            std::span<const Spectrum> pending, int order, std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean);

}  // namespace atrium
