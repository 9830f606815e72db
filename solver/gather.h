// Gather: light across the links of a braid into the receiver's slots. [THFH94 §5.1 step 3(e)]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "solver/link.h"
#include "solver/placed_light.h"
#include "solver/push_pull.h"

namespace atrium {

// What a patch receives in all, and the mean that closes its row where no leaf's own doubts do.
// That a row sums to what does not leave the scene corrects its links by their share of the doubt,
// as least squares would.
struct RowMean {
  double form_factors = 0;  // Σ F A, m²
  DoubtSlot doubts;         // Σ A times those of its elements
};

// What one patch or group of a source sends, looked up once for all links from its elements. It
// refers to its record, or to the tree that stands for it.
class Sender {
 public:
  // pending: lx, all over the patch, or by_place where there are such.
  Sender(const PatchView& patch, const Spectrum& pending, std::span<const Spectrum> by_place,
         double detail_share);
  Sender(const FaceGroup& group, const Spectrum& pending);

  // B = M + ρE, lm/m², coefficient by coefficient; of a group its mean alone.
  std::array<Spectrum, kMaxCoefficients> radiosity(std::uint32_t element) const;
  Spectrum mean_radiosity(std::uint32_t element) const;  // its first coefficient
  // lm/m², luminance, root mean square of what B so leaves out of the element; 0 of groups, and
  // where light leaves the scene.
  double detail(std::uint32_t element) const;
  // Of that, the share that goes where coarse links go.
  double detail_share() const { return detail_share_; }

 private:
  // lm/m², of B's mean: what is not ρE.
  Spectrum constant(std::uint32_t element) const {
    if (pending_.empty()) return constant_;
    return constant_ +
           reflectance_ * pending_[place_among(pending_.size(), elements_[element].place)];
  }

  std::span<const Element> elements_;  // empty: a group
  const double* e_ = nullptr;
  std::span<const Spectrum> pending_;  // by place; empty: part of constant_
  int k_ = 0;
  Spectrum reflectance_{0};
  Spectrum constant_{0};  // lm/m², all over the patch or group
  double detail_sent_ = 0, detail_share_ = 0;
};

// What a source cluster sends: of its record, or, where a cluster gathers from itself, of what its
// patches hold by now. It refers to both, and to what is pending.
class SourceLight {
 public:
  // pending: added to E as it is read.
  // detail_share: by the source's patches, see sent_detail. Empty: none.
  // installed: the source's patches, pending included, that are read in the place of the record's.
  SourceLight(const ClusterView& record, const PlacedLight& pending,
              std::span<const double> detail_share = {}, std::span<const PatchTree> installed = {})
      : record_(record), pending_(pending), detail_share_(detail_share), installed_(installed) {}

  Sender of(std::uint32_t patch_or_group) const;
  // Do face groups stand for some of its patches?
  bool grouped() const { return !record_.groups().groups.empty(); }

 private:
  const ClusterView& record_;
  const PlacedLight& pending_;
  std::span<const double> detail_share_;
  std::span<const PatchTree> installed_;
};

// What a strand's links have brought of one source patch. Light that leaves a patch arrives
// somewhere, so over all that see it B's detail adds nothing: what links from fine elements bring
// of it, more or less than the patch's mean would, is what those from coarse ones, which leave it
// out, should have brought less or more. Left alone, bright spots that light what is near them dim
// the rest: .2% a bounce in a cube, ten times that in all where ρ = .9.
struct SentDetail {
  std::uint32_t source_patch = 0;
  double factors = 0;   // m², Σ F A of the receivers
  double sent = 0;      // lm, luminance
  double left_out = 0;  // lm, Σ F A detail
};

// Adds one strand's transfers from `source` to the slots of its receiving patch or group, the
// latter as one element.
// cap: lm/m², luminance above which a source does not count in full in `mean`.
// details: what came of each of the source's patches is added, in runs; nullptr: nobody asks.
void gather(const Braid& braid, const Braid::Strand& strand, const SourceLight& source, int order,
            std::span<const Element> receiver, double cap, GatherSlots& slots, RowMean& mean,
            std::vector<SentDetail>* details);

}  // namespace atrium
