// Refinement: which pairs of elements are linked, between which levels. Coarse pairs first; a pair
// whose link would be in error by more than it may is split, the receiver where its shape misses
// the transfer, the source where its own variation or a shadow's edge is at fault. The error of a
// link is weighed by the radiosity that crosses it, by the light that is there already, and by the
// receiver's area: what counts is what reaches the picture. [HSA91; facts: error × area^½]
//
// Where clusters have face groups, pairs start at those, on either side, and go down to patches
// where a group will not do (refine_groups.cpp). What ends see of each other: refine_sight.cpp.
//
// One Refiner works for one receiving patch after the other; several work side by side on others.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "solver/branch.h"
#include "solver/coupling.h"
#include "solver/face_groups.h"
#include "solver/form_factor.h"
#include "solver/link.h"
#include "solver/outline.h"
#include "solver/refine_counters.h"
#include "visibility/occlusion.h"
#include "visibility/tube.h"

namespace atrium {

struct RefineSettings {
  double threshold = 0.02;     // of the weighed error of a link
  double mean_irradiance = 1;  // lm/m², luminance over lit surfaces: the scale of errors
  double ambient = 0;          // lm/m², irradiance assumed where nothing was gathered yet
  double reference_area = 1;   // m², what a surface sees, in the mean
  double min_edge = 0.0254;    // m, no element is split below it
  double tolerance = 1e-5;     // m, the scene's
};

// What an element sends, as refinement sees it.
struct Sending {
  double radiosity = 0;  // lm/m², luminance, mean
  double detail = 0;     // lm/m², of B's variation below this element
};

// A source cluster's patches, ready to be linked to: the roots of those in no group.
struct SourceRoots {
  struct Alone {
    std::uint32_t patch = 0;
    Sending sends;
    Site site;
  };
  std::vector<PatchView> patches;
  std::vector<Alone> alone;           // but the inert ones
  GroupView groups;                   // numbered after the patches
  std::span<const Spectrum> pending;  // lx, by patch, to be added to E; empty: nothing is
  explicit SourceRoots(const ClusterView& source, double ambient = 0,  // as RefineSettings has it
                       std::span<const Spectrum> pending = {});
  SourceRoots() = default;
};

// A receiving cluster with groups: its trees and where the links go, the patches' first, then the
// groups'.
struct GroupReceiver {
  std::span<PatchTree> trees;
  GroupView groups;
  std::span<LinkSet> sets;
};

// What may stand between: blockers by shaft and by ray. Both null where nothing can.
struct Surroundings {
  const BlockerIndex* index = nullptr;
  const RayScene* rays = nullptr;
};

class Refiner {
 public:
  Refiner(const RefineSettings& settings, const Surroundings& around)
      : settings_(settings), around_(around) {}

  // Before the first link: leaves of R's patches are split along what stands on them, where the
  // light that is there already jumps by more than their links' errors together may be.
  void cut_at_contacts(PatchTree& receiver);

  // 3(d) Install( links in Braid(R, S, T) ) for one patch of R: top-level links between visible
  // patch pairs, refined on the spot. Splits leaves of `receiver`. The thin ones may still wait for
  // a full packet of rays: `out` is complete after flush(). [THFH94 §5.1]
  // Patches that `stays` names, by their number in the source, are not asked again.
  void link(PatchTree& receiver, const SourceRoots& source, LinkSet& out,
            const std::vector<bool>& stays = {});
  // The branch's part of that.
  void link(Branch& receiver, const SourceRoots& source, LinkSet& out,
            const std::vector<bool>& stays = {});
  // The same for a group that is part of no other, and all patches in it.
  void link(const GroupReceiver& receiver, std::uint32_t group, const SourceRoots& source);
  void flush();

  // Of what the level before decided, `out` gets that which would be decided the same now; by the
  // source's patches and groups, whether it was. Of groups nothing is taken over.
  std::vector<bool> take_over(const Braid& before, const Braid::Strand& strand,
                              const SourceRoots& source, LinkSet& out);

  const RefineCounters& counters() const { return counters_; }

 private:
  // One end of a pair on its way down. A source may be a part of a leaf, or of any element what is
  // in front of the receiver's plane.
  struct Source {
    const PatchView* patch = nullptr;
    std::uint32_t patch_index = 0;
    std::int32_t element = 0;
    bool part = false;
    bool in_front = false;  // the site is what of it is in front of the receiver's plane
    const Site* site = nullptr;
    Sending sends;
    const FaceGroup* group = nullptr;  // in place of patch and site
  };
  // An element of tree_, or a group of the receiver's.
  struct Target {
    std::int32_t number = 0;
    const Site* site = nullptr;  // of an element
    const FaceGroup* group = nullptr;
  };
  // What a pair sees of each other, as form factors.
  struct Sight {
    Kernel seen;
    double misfit = 0;    // of the receiver's basis to it, root mean square
    double shadow = 0;    // what may be wrong of it by what stands between, root mean square
    double variance = 0;  // of its mean
  };
  struct Waiting {  // a thin link before its ray
    ThinLink link;
    Vec3 from, to;
    LinkSet* out;
  };

  Source end_of(const SourceRoots::Alone& root) const;
  Source make_source(const PatchView& patch, std::uint32_t index, std::int32_t element,
                     const Site& site) const;
  void descend(std::int32_t receiver, const Site& site, const Source& source, const Tube* parent);
  static Outline outline_of(const Source& source);
  void descend_in_front(std::int32_t receiver, const Site& site, const Source& source,
                        const Tube* parent);
  void descend_receiver(std::int32_t receiver, const Source& source, const Tube& tube);
  bool descend_source(std::int32_t receiver, const Site& site, const Source& source,
                      const Tube& tube);
  Variety look_through(Tube& tube, const Tube* parent, std::int32_t receiver, const Site& site,
                       const Source& source, const Kernel& open, bool goes_down, Sight& sight);
  Variety glance(Tube& tube, const Tube* parent, std::int32_t receiver, const Site& site,
                 const Source& source, const Kernel& open, bool heavy, Sight& sight);
  Tube skip_tube(const Tube* parent);
  Variety draw(Tube& tube, const Tube* parent, const Site& r, const Site& s);
  Sight see(std::int32_t receiver, const Site& site, const Source& source, const Kernel& open,
            const Kernel& seen);
  bool measure(std::int32_t receiver, const Site& r, const Source& source, const Kernel& open,
               const Tube& tube, Sight& sight) const;
  Kernel seen_by_rays(const Site& receiver, const Site& source, const Kernel& open);
  double scattered_share(const Site& receiver, const Site& source);
  void thin_link(std::int32_t receiver, const Site& site, const Source& source);
  void thin_link(std::int32_t receiver, const Source& source, const SurfacePoint& from,
                 const SurfacePoint& to, double source_area);
  static Verdict verdict(const Source& source, const Sight& sight, const Kernel& open, bool by_ray,
                         double spread, double dark, double weighs);
  void full_link(std::int32_t receiver, const Site& site, const Source& source, const Sight& sight,
                 bool by_ray);
  bool goes_down_to(std::int32_t element) const {
    return !branch_ || branch_->goes_down_to(element);
  }
  bool links(std::int32_t element) const { return !branch_ || branch_->links(element); }
  double misfit(std::int32_t receiver, const Site& site, const Kernel& kernel) const;
  double light_on(std::int32_t receiver) const;
  double weight(std::int32_t receiver, double arriving) const;
  bool splits(std::int32_t receiver);
  static double alike(const Source& source);

  // Pairs of which one end or both are groups.
  Source group_source(std::uint32_t group) const;
  void meet(const Target& target, const Source& source);
  void meet_roots(std::int32_t receiver, const Site& site, const Source& source);
  void descend_group(const Target& target, const Source& source);
  bool split_source(const Target& target, const Source& source);
  bool split_target(const Target& target, const Source& source);
  Site site_of(const Target& target, std::uint64_t seed) const;
  Site site_of(const Source& source, std::uint64_t seed) const;
  Sight see_group(const Target& target, const Source& source, const Site& r, const Site& s,
                  const Kernel& open);
  void thin_group_link(const Target& target, const Source& source);
  std::uint64_t seed_of(const Target& target, const Source& source) const;
  double misfit(const Target& target, const Site& site, const Kernel& kernel) const;
  double weight(const Target& target, double arriving) const;

  RefineSettings settings_;
  Surroundings around_;
  RefineCounters counters_;
  PatchTree* tree_ = nullptr;
  const Branch* branch_ = nullptr;  // that tree_ is of; null where it is whole
  int order_ = 1;
  std::span<const Spectrum> pending_;  // of the source at hand
  std::optional<Verdict> verdict_;     // of the patch pair at hand, if it needed no refining
  LinkSet* out_ = nullptr;
  std::vector<Waiting> waiting_;
  const SourceRoots* source_ = nullptr;
  const PatchTree* rooted_ = nullptr;  // the tree that root_ is of
  Site root_;
  const GroupReceiver* receiver_ = nullptr;  // null where a patch alone receives
};

}  // namespace atrium
