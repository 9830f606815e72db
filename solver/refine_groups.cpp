// Refinement of pairs of which one end or both are groups of faces. A group is looked at by a few
// points of its faces, each with its own normal, and by rays between those and the other end's: the
// group's own faces stand in their way as all others do. Where that leaves too much open, the end
// that is at fault goes down: a group to its halves and at last to patches, an element to its
// children; two patches are left to refine.cpp.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/squared.h"
#include "solver/element_tree.h"
#include "solver/pair_terms.h"
#include "solver/refine.h"
#include "solver/sample_sequence.h"

namespace atrium {

namespace {

// Of what may pass between two ends none of whose nodes face each other: the rule of succession,
// over sixteen pairs.
constexpr double kUnseen = 1.0 / (kRayLanes + 2);
// Variance of a group's transfers over all its faces, from that over its nodes. [Bessel]
constexpr double kOfSample = double(kGroupNodes) / (kGroupNodes - 1);

// What is left open by sixteen segments, against kMixed and kUnsure of elements: a group's four
// points are of four faces, and what hides one need not hide the next. Found on an office: half of
// it left 4% more error for 4% fewer links. Which end goes down is not asked of it.
constexpr double kApart = 4;
// What else a group gets wrong, relative to what its nodes differ by: it goes up and down from face
// to face. Found likewise: 1 took 3% more links for no less error.
constexpr double kUneven = 0.6;
// Of the most that a group's faces may get by chance beside what its nodes tell, how much is taken
// to be missed. Found on institute and hospital: 1 made a tenth more links for no less error.
constexpr double kMissed = 0.5;

// An end of a pair from afar: what it is of lies within the ball, and looks into the cone.
struct Outlook {
  Vec3 center{0}, axis{0};
  double radius = 0, area = 0, cone = 0;
};

Outlook outlook_of(const FaceGroup& g) { return {g.center, g.axis, g.radius, g.area, g.cone}; }
Outlook outlook_of(const Site& s) { return {s.center, s.normal, s.radius, s.area, 0}; }

double angle(const Vec3& a, const Vec3& b) { return std::acos(std::clamp(dot(a, b), -1.0, 1.0)); }

// The most that cosθ cosθ' can be. What two planes see of each other lies between them: the share
// of a hemisphere that is in front of both is sin² of half the angle of their normals.
double cosine_bound(const Outlook& r, const Outlook& s) {
  const double between = std::min(std::numbers::pi, angle(r.axis, s.axis) + r.cone + s.cone);
  const double wedge = squared(std::sin(between / 2));
  const Vec3 d = s.center - r.center;
  const double distance = length(d), reach = r.radius + s.radius;
  if (distance <= reach) return wedge;
  const double spread = std::asin(reach / distance);
  const double at_r = std::max(0.0, angle(r.axis, d / distance) - r.cone - spread);
  const double at_s = std::max(0.0, angle(s.axis, -d / distance) - s.cone - spread);
  if (std::max(at_r, at_s) >= std::numbers::pi / 2) return 0;
  return std::min(wedge, std::cos(at_r) * std::cos(at_s));
}

double gap_between(const Outlook& r, const Outlook& s) {
  return length(s.center - r.center) - r.radius - s.radius;
}

double form_factor_bound(const Outlook& r, const Outlook& s) {
  const double gap = std::max(0.0, gap_between(r, s));
  const double area = s.area, ball = std::numbers::pi * squared(gap);
  return cosine_bound(r, s) * (area < ball ? area / ball : 1);
}

// What a group's few nodes may miss of a transfer, root mean square over its faces, as a form
// factor. One pane is seen by the frames of its own window and by no others of the façade. Nodes do
// not tell: where none of theirs sees the pane nothing is found, where one does the pair goes down,
// and so what is left falls short, always. It is bounded beforehand: no face gets more than the
// bound, all of them not more than reciprocity lets them, and from afar one is like the other.
double missed_by_nodes(const Outlook& r, const Outlook& s, double bound, double group_radius) {
  const double alike = group_radius / (group_radius + std::max(0.0, gap_between(r, s)));
  return kMissed * squared(alike) * bound * std::sqrt(std::min(1.0, s.area / (bound * r.area)));
}

// How a transfer varies over a group's faces, from what its nodes send.
double spread_over_nodes(const Site& r, const Site& s, const Kernel& kernel) {
  const double mean_square = mean_square_over_source(r, s, kernel);
  return std::sqrt(kOfSample * std::max(0.0, mean_square - squared(kernel.mean)));
}

// A group close over a large element lights a spot of it that need hold no node. How much arrives
// is known from the group's side; the rest as for a probe.
double spot(const Site& element, const Site& group, double mean) {
  double sent = 0;
  for (int l = 0; l < group.nodes; ++l)
    sent += group.weight[l] * point_to_polygon_in_sum(group.x[l], group.n[l], element.polygon());
  const double height = dot(element.normal, group.center - element.center);
  const double share = (group.area + std::numbers::pi * squared(height)) / element.area;
  if (share >= 1) return 0;
  const double factor = std::min(1.0, sent * group.area / (element.area * share));
  return std::sqrt(share * (1 - share * share)) * std::abs(factor - mean);
}

}  // namespace

void Refiner::link(const GroupReceiver& receiver, std::uint32_t group, const SourceRoots& source) {
  receiver_ = &receiver;
  source_ = &source;
  pending_ = source.pending;
  order_ = receiver.trees.front().order;
  const Target target{std::int32_t(group), nullptr, &receiver.groups.groups[group]};
  for (const SourceRoots::Alone& q : source.alone) descend_group(target, end_of(q));
  for (std::uint32_t g = 0; g < source.groups.groups.size(); ++g)
    if (!source.groups.groups[g].inner) descend_group(target, group_source(g));
}

Refiner::Source Refiner::group_source(std::uint32_t group) const {
  const FaceGroup& g = source_->groups.groups[group];
  Source s;
  s.patch_index = static_cast<std::uint32_t>(source_->patches.size()) + group;
  s.group = &g;
  Spectrum radiosity = g.radiosity;
  if (!pending_.empty()) radiosity += g.reflectance * pending_[source_->groups.any_patch(g)];
  s.sends.radiosity = std::max(luminance(radiosity), luminance(g.reflectance) * settings_.ambient);
  s.sends.detail = g.detail;
  return s;
}

void Refiner::meet(const Target& target, const Source& source) {
  if (target.group || source.group) return descend_group(target, source);
  meet_roots(target.number, *target.site, source);
}

void Refiner::descend_group(const Target& target, const Source& source) {
  const Outlook r = target.group ? outlook_of(*target.group) : outlook_of(*target.site);
  const Outlook s = source.group ? outlook_of(*source.group) : outlook_of(*source.site);
  const double factor = form_factor_bound(r, s);
  const double bound = factor * std::max(source.sends.radiosity + source.sends.detail,
                                         kDarkest * settings_.mean_irradiance);
  const double most = bound * weight(target, 0);
  if (!(most >= kNegligible * settings_.threshold)) return;
  if (most < kThin * settings_.threshold) return thin_group_link(target, source);
  // An element no larger than a group that it touches sees parts of it alone.
  const bool close = gap_between(r, s) <= 0;
  if (close && source.group && !target.group && s.radius >= r.radius) {
    split_source(target, source);
    return;
  }
  if (close && target.group && !source.group && r.radius >= s.radius) {
    split_target(target, source);
    return;
  }

  const std::uint64_t seed = seed_of(target, source);
  const Site from = site_of(target, seed), to = site_of(source, seed);
  const Kernel open = make_kernel(from, to);
  ++counters_.kernels;
  if (!close && !(open.mean > 0) && kUnseen * most <= settings_.threshold) return;

  const std::uint64_t rays_before = counters_.rays;
  const Sight sight = see_group(target, source, from, to, open);
  const double spread =
      source.group ? spread_over_nodes(from, to, open) : sensitivity_spread(from, to, open);
  double shape = sight.misfit;
  if (!target.group && close)
    shape = std::sqrt(squared(shape) + squared(spot(from, to, open.mean)));
  const double missed = open.mean > 0 ? 0 : kUnseen * bound;
  const double receiving = source.sends.radiosity * shape + missed;
  const bool whole = sight.seen.mean >= open.mean;
  const double variation = source.sends.detail * std::max(spread, whole ? 0 : kHidden * open.mean);
  const double drawn = source.group ? source.sends.radiosity * spread / std::sqrt(kGroupNodes) : 0;
  const double sending = std::sqrt(squared(variation) + squared(drawn));
  const double shadow = source.sends.radiosity * sight.shadow;
  const double by_nodes = missed_by_nodes(r, s, factor, target.group ? r.radius : s.radius);
  const double error =
      std::max(std::sqrt(squared(kUneven) * (squared(receiving) + squared(sending)) +
                         squared(kApart * shadow)),
               source.sends.radiosity * by_nodes);
  const double arriving = source.sends.radiosity * darkest_row(sight.seen);

  if (error * weight(target, arriving) > settings_.threshold) {
    const bool source_first = sending > std::max(receiving, shadow) ||
                              (shadow > receiving && s.radius > r.radius) ||
                              (source.group && !target.group && s.radius > r.radius);
    if (source_first && split_source(target, source)) return;
    if (split_target(target, source)) return;
    if (!source_first && split_source(target, source)) return;
  }
  Source end = source;
  end.site = &to;
  if (target.group) out_ = &receiver_->sets[receiver_->trees.size() + target.number];
  full_link(target.group ? 0 : target.number, from, end, sight, counters_.rays > rays_before);
}

// What gets through, node pair by node pair. Where all segments agree on what would be heavy in the
// dark, sixteen more between other faces are asked: a lamp's shadow is seen by what it leaves dark.
Refiner::Sight Refiner::see_group(const Target& target, const Source& source, const Site& r,
                                  const Site& s, const Kernel& open) {
  constexpr std::uint64_t kAgain = 3;  // another draw than the first
  Sight sight;
  sight.seen = open;
  double v = 1;
  if (around_.rays && open.mean > 0) {
    sight.seen = seen_by_rays(r, s, open);
    v = seen_share(r, open, sight.seen);
    const double transfer = source.sends.radiosity * open.mean;
    if ((v == 0 || v == 1) && kUnsureFour * transfer * weight(target, 0) > settings_.threshold) {
      const std::uint64_t seed = derived(seed_of(target, source), kAgain);
      const Site r2 = site_of(target, seed), s2 = site_of(source, seed);
      const Kernel other = make_kernel(r2, s2);
      if (other.mean > 0) v = 0.5 * (v + seen_share(r2, other, seen_by_rays(r2, s2, other)));
    }
    sight.shadow = std::max(kUnsure, kMixed * std::sqrt(v * (1 - v))) * open.mean;
  }
  sight.misfit = misfit(target, r, sight.seen);
  double drawn2 = 0;
  if (target.group) drawn2 += squared(sight.misfit) / kGroupNodes;
  if (source.group) drawn2 += squared(spread_over_nodes(r, s, sight.seen)) / kGroupNodes;
  sight.variance = squared(kUnsureShape * open.mean) + drawn2;
  if (around_.rays) sight.variance += variance_of(open.mean, v);
  return sight;
}

bool Refiner::split_source(const Target& target, const Source& source) {
  if (source.group) {
    for (const std::int32_t c : source.group->child) {
      if (c >= 0) {
        meet(target, group_source(std::uint32_t(c)));
        continue;
      }
      const PatchView& patch = source_->patches[std::size_t(~c)];
      const Site site = make_site(patch, 0);
      meet(target, make_source(patch, std::uint32_t(~c), 0, site));
    }
    return true;
  }
  const Element& x = source.patch->elements[source.element];
  if (x.leaf()) return false;
  for (std::int32_t c = x.child; c < x.child + 2; ++c) {
    const Site half = make_site(*source.patch, c);
    meet(target, make_source(*source.patch, source.patch_index, c, half));
  }
  return true;
}

bool Refiner::split_target(const Target& target, const Source& source) {
  if (target.group) {
    for (const std::int32_t c : target.group->child) {
      if (c >= 0) {
        meet({c, nullptr, &receiver_->groups.groups[std::size_t(c)]}, source);
        continue;
      }
      tree_ = &receiver_->trees[std::size_t(~c)];
      out_ = &receiver_->sets[std::size_t(~c)];
      const Site site = make_site(tree_->view(), 0);
      meet({0, &site}, source);
    }
    return true;
  }
  const bool leaf = tree_->elements[target.number].leaf();
  if (leaf && !split_leaf(*tree_, target.number, settings_.min_edge)) return false;
  ++counters_.splits;
  const std::int32_t child = tree_->elements[target.number].child;
  for (std::int32_t c = child; c < child + 2; ++c) {
    if (!goes_down_to(c)) continue;
    const Site site = make_site(tree_->view(), c);
    meet({c, &site}, source);
  }
  return true;
}

// Not the elements' coordinates but who they are: the same in any thread.
std::uint64_t Refiner::seed_of(const Target& target, const Source& source) const {
  const std::uint32_t r =
      target.group ? receiver_->trees[receiver_->groups.any_patch(*target.group)].head.patch
                   : tree_->head.patch;
  const std::uint32_t s =
      source.group ? source_->patches[source_->groups.any_patch(*source.group)].head->patch
                   : source.patch->head->patch;
  const std::uint64_t number = std::uint64_t(target.number) << 32 | source.patch_index;
  return derived(derived(derived(r, s), number), std::uint64_t(source.element));
}

Site Refiner::site_of(const Target& target, std::uint64_t seed) const {
  if (!target.group) return *target.site;
  const auto members = drawn_members(receiver_->groups, *target.group, seed);
  std::array<PatchView, kGroupNodes> drawn;
  for (int k = 0; k < kGroupNodes; ++k) drawn[k] = receiver_->trees[members[k]].view();
  return make_site(*target.group, drawn, seed);
}

Site Refiner::site_of(const Source& source, std::uint64_t seed) const {
  constexpr std::uint64_t kOther = 2;  // the ends' draws have nothing in common
  if (!source.group) return *source.site;
  const auto members = drawn_members(source_->groups, *source.group, derived(seed, kOther));
  std::array<PatchView, kGroupNodes> drawn;
  for (int k = 0; k < kGroupNodes; ++k) drawn[k] = source_->patches[members[k]];
  return make_site(*source.group, drawn, derived(seed, kOther));
}

// One node of either end stands for the whole transfer.
void Refiner::thin_group_link(const Target& target, const Source& source) {
  const std::uint64_t seed = seed_of(target, source);
  const Site from = site_of(target, seed), to = site_of(source, seed);
  const int k = int(seed % std::uint64_t(from.nodes)),
            l = int((seed >> 8) % std::uint64_t(to.nodes));
  if (target.group) out_ = &receiver_->sets[receiver_->trees.size() + target.number];
  thin_link(target.group ? 0 : target.number, source, {from.x[k], from.n[k]}, {to.x[l], to.n[l]},
            to.area);
}

double Refiner::misfit(const Target& target, const Site& site, const Kernel& kernel) const {
  if (!target.group) return misfit(target.number, site, kernel);
  double rest2 = 0;
  for (int k = 0; k < kernel.rows; ++k)
    rest2 += site.weight[k] * squared(kernel.row[k] - kernel.mean);
  return std::sqrt(kOfSample * rest2);
}

double Refiner::weight(const Target& target, double arriving) const {
  if (!target.group) return weight(target.number, arriving);
  const FaceGroup& g = *target.group;
  const double here = g.irradiance - kDarkEnd * g.irradiance_detail;
  return std::sqrt(g.area / settings_.reference_area) /
         std::max({settings_.mean_irradiance, here, arriving});
}

}  // namespace atrium
