#include "solver/refine.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "engine/squared.h"
#include "solver/element_tree.h"
#include "solver/outline.h"
#include "solver/pair_terms.h"

namespace atrium {

namespace {

// A source's leaf is cut in parts no smaller than this share of it.
constexpr double kSmallestPart = 1.0 / 64;

// A transfer that is not seen is in doubt where its standard deviation is more than this: ten
// thousand such sources leave a hundredth of the row open.
constexpr double kLeastDoubt = 1e-4;

void note_unseen(const Ends& ends, double doubt, LinkSet& out) {
  if (doubt > squared(kLeastDoubt)) out.doubts.push_back({ends, static_cast<float>(doubt)});
}

std::uint32_t mix(std::uint32_t x) {  // a hash of the pair, never a running generator
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

// Where nothing was gathered yet, `ambient` is assumed.
Sending sent_by(const PatchView& patch, std::int32_t element, const Spectrum& pending,
                double ambient) {
  const std::span<const double> e = patch.e_of(element);
  const Spectrum& rho = patch.head->reflectance;
  const double gathered = luminance(rho * (Spectrum{e[0], e[1], e[2]} + pending));
  const double assumed = luminance(rho) * ambient;
  return {luminance(patch.head->exitance) + std::max(gathered, assumed),
          luminance(rho) * patch.elements[element].detail};
}

}  // namespace

SourceRoots::SourceRoots(const ClusterView& source, double ambient,
                         std::span<const Spectrum> light)
    : groups(source.groups()), pending(light) {
  std::vector<bool> grouped(source.size(), false);
  for (const GroupMember& m : groups.members) grouped[m.patch] = true;
  patches.reserve(source.size());
  alone.reserve(source.size());  // they are large
  for (std::size_t p = 0; p < source.size(); ++p) {
    const PatchView& patch = patches.emplace_back(source.patch(p));
    if (grouped[p] || patch.head->inert) continue;
    alone.emplace_back(static_cast<std::uint32_t>(p),
                       sent_by(patch, 0, light.empty() ? Spectrum{0} : light[p], ambient),
                       make_site(patch, 0));
  }
}

// Light jumps where something stands on a surface, all of it at once: link by link it would be
// little each time, and what is dark under a box stay as bright as what is beside it.
void Refiner::cut_at_contacts(PatchTree& receiver) {
  tree_ = &receiver;
  for (std::size_t i = 0; i < receiver.elements.size(); ++i) {
    const Element& x = receiver.elements[i];
    if (!x.leaf() || x.crossing == 0) continue;
    const double light = light_on(std::int32_t(i));
    const double error = kJump * light * x.crossing * weight(std::int32_t(i), 0);
    if (error > kJumpOfLinks * settings_.threshold)
      split_leaf(receiver, std::int32_t(i), settings_.min_edge);
  }
}

void Refiner::link(PatchTree& receiver, const SourceRoots& source, LinkSet& out,
                   const std::vector<bool>& stays) {
  if (rooted_ != &receiver) root_ = make_site(receiver.view(), 0);
  tree_ = &receiver;
  rooted_ = &receiver;
  out_ = &out;
  pending_ = source.pending;
  source_ = &source;
  order_ = receiver.order;
  for (const SourceRoots::Alone& q : source.alone) {
    if (!stays.empty() && stays[q.patch]) continue;
    verdict_.reset();
    meet_roots(0, root_, end_of(q));
    if (verdict_ && links(0)) out.verdicts.push_back(*verdict_);
  }
  for (std::uint32_t g = 0; g < source.groups.groups.size(); ++g)
    if (!source.groups.groups[g].inner) descend_group({0, &root_}, group_source(g));
}

Refiner::Source Refiner::end_of(const SourceRoots::Alone& root) const {
  Source s;
  s.patch = &source_->patches[root.patch];
  s.patch_index = root.patch;
  s.site = &root.site;
  s.sends = root.sends;
  return s;
}

void Refiner::link(Branch& receiver, const SourceRoots& source, LinkSet& out,
                   const std::vector<bool>& stays) {
  branch_ = &receiver;
  link(receiver.tree, source, out, stays);
  branch_ = nullptr;
}

std::vector<bool> Refiner::take_over(const Braid& before, const Braid::Strand& strand,
                                     const SourceRoots& source, LinkSet& out) {
  std::vector<bool> stays(source.patches.size() + source.groups.groups.size(), false);
  const std::span verdicts = before.verdicts;
  auto at = source.alone.begin();
  for (const Verdict& v : verdicts.subspan(strand.first_verdict, strand.verdicts)) {
    at = std::find_if(at, source.alone.end(),  // both ascend, and no patch joins or leaves a group
                      [&](const SourceRoots::Alone& a) { return a.patch == v.source_patch; });
    ATRIUM_CHECK(at != source.alone.end());
    const auto& [radiosity, detail] = at->sends;
    const double error =
        std::max<double>(v.at_least, v.of_light * (radiosity + detail) + v.of_detail * detail);
    if (!(error <= settings_.threshold)) continue;
    stays[v.source_patch] = true;
    out.verdicts.push_back(v);
  }
  const std::size_t k2 = before.links.empty() ? 0 : before.couplings.size() / before.links.size();
  for (std::size_t i = strand.first_link; i < strand.first_link + strand.links; ++i) {
    if (!stays[before.links[i].ends.source_patch]) continue;
    out.links.push_back(before.links[i]);
    const auto coupling = before.couplings.begin() + std::ptrdiff_t(i * k2);
    out.couplings.insert(out.couplings.end(), coupling, coupling + std::ptrdiff_t(k2));
  }
  for (const Doubt& d : std::span(before.doubts).subspan(strand.first_doubt, strand.doubts))
    if (stays[d.ends.source_patch]) out.doubts.push_back(d);
  return stays;
}

// A pair of patches, or of an element and a patch.
void Refiner::meet_roots(std::int32_t receiver, const Site& site, const Source& source) {
  if (source.patch->head->patch == tree_->head.patch) return;
  if (!facing(site, *source.site, settings_.tolerance)) return;
  descend(receiver, site, source, nullptr);
}

Refiner::Source Refiner::make_source(const PatchView& patch, std::uint32_t index,
                                     std::int32_t element, const Site& site) const {
  Source s;
  s.patch = &patch;
  s.patch_index = index;
  s.element = element;
  s.site = &site;
  s.sends = sent_by(patch, element, pending_.empty() ? Spectrum{0} : pending_[index],
                    settings_.ambient);
  return s;
}

// Misfit of the receiver's basis to the transfer across its nodes, centre and probes, as a form
// factor, root mean square over the receiver.
double Refiner::misfit(std::int32_t receiver, const Site& r, const Kernel& kernel) const {
  const PatchView patch = tree_->view();
  const int n = patch.k();
  const std::array<double, kMaxNodes>& f = kernel.row;
  BasisValues fit{};
  for (int k = 0; k < kernel.rows; ++k)
    for (int a = 0; a < n; ++a) fit[a] += r.weight[k] * r.test(k)[a] * f[k];
  const auto fit_of = [&](const BasisValues& phi) {
    double at = 0;
    for (int a = 0; a < n; ++a) at += fit[a] * phi[a];
    return at;
  };
  double rest2 = 0;
  for (int k = 0; k < kernel.rows; ++k) rest2 += r.weight[k] * squared(f[k] - fit_of(r.phi[k]));
  rest2 /= r.cubic_seen;
  const BasisValues center = evaluate_basis(patch.basis_of(receiver), patch.elements[receiver],
                                            patch.order, patch.elements[receiver].centroid);
  const double bowl = r.bowl * (kernel.center - fit_of(center));
  for (const Probe& probe : std::span(kernel.probes).first(kernel.probe_count)) {
    const double share = probe.area / r.area;
    if (share >= 1) continue;
    const BasisValues phi = evaluate_basis(patch.basis_of(receiver), patch.elements[receiver],
                                           patch.order, patch.head->frame.to_plane(probe.at));
    // The larger its part of the element, the more the nodes have seen of it.
    rest2 += share * (1 - share * share) * squared(probe.factor - fit_of(phi));
  }
  return std::sqrt(rest2 + squared(bowl));
}

// lx, luminance, in the mean; where nothing was gathered yet, what is assumed.
double Refiner::light_on(std::int32_t receiver) const {
  const std::span<const double> e = tree_->view().e_of(receiver);
  return std::max(settings_.ambient, luminance({e[0], e[1], e[2]}));
}

// What a unit of irradiance error on this element weighs. Errors are relative to the light that is
// there, at the element's dark end: a shadow's edge beside a lamp counts by its dark side.
// arriving: lx, what the link itself brings at the least.
double Refiner::weight(std::int32_t receiver, double arriving) const {
  const Element& x = tree_->elements[receiver];
  const int k = coefficient_count(tree_->order);
  const double* e = &tree_->e[std::size_t(receiver) * k * kChannels];
  double here = luminance({e[0], e[1], e[2]}), slope2 = squared(x.detail);
  for (int a = 1; a < k; ++a) slope2 += squared(luminance({e[3 * a], e[3 * a + 1], e[3 * a + 2]}));
  here -= kDarkEnd * std::sqrt(slope2);
  return std::sqrt(x.area / settings_.reference_area) /
         std::max({settings_.mean_irradiance, here, arriving});
}

void Refiner::descend(std::int32_t receiver, const Site& site, const Source& source,
                      const Tube* parent) {
  // Dark sources fill rows as well: what they cover is not to be taken for the room's mean.
  const double bound =
      form_factor_bound(site, *source.site) *
      std::max(source.sends.radiosity + source.sends.detail, kDarkest * settings_.mean_irradiance);
  const double most = bound * weight(receiver, 0);
  if (most < kNegligible * settings_.threshold) return;
  if (most < kThin * settings_.threshold) return thin_link(receiver, site, source);

  const Kernel open = make_kernel(site, *source.site);
  ++counters_.kernels;
  if (!(open.mean > 0) && !(open.center > 0) && !facing(site, *source.site, settings_.tolerance)) {
    if (!parent) verdict_.emplace(source.patch_index);
    return;
  }
  if (open.behind && !source.in_front) return descend_in_front(receiver, site, source, parent);

  // What a row misses of a source close by is taken for the room's mean, in the dark under a box as
  // anywhere: so much is at stake though the source be dark. And it stands before what else the
  // receiver sees, which is as bright as it takes to make its light.
  const bool close = open.probe_count > 0;
  const double behind = light_on(receiver) - source.sends.radiosity;
  const double dark = close ? std::max(kDarkStake * settings_.mean_irradiance, behind) : 0;
  const double stake = std::max(source.sends.radiosity, dark);
  double spread = open.mean;  // or less, but nothing of it varies yet
  if (close || source.sends.detail > 0) spread = sensitivity_spread(site, *source.site, open);
  // What the shape alone gets wrong needs no ray to be known.
  Sight sight{open, misfit(receiver, site, open), 0, squared(kUnsureShape * open.mean)};
  Tube tube;
  const std::uint64_t rays_before = counters_.rays;
  if (around_.index) {
    const double by_shape =
        std::sqrt(squared(stake * sight.misfit) + squared(source.sends.detail * spread));
    const double arriving = source.sends.radiosity * darkest_row(open);
    const bool goes_down = by_shape * weight(receiver, arriving) > settings_.threshold;
    const Variety variety =
        look_through(tube, parent, receiver, site, source, open, goes_down, sight);
    if (variety == Variety::INVISIBLE) {
      if (!parent) verdict_.emplace(source.patch_index);
      return;
    }
    // What is hidden of the source need not be as bright as what is seen.
    if (variety == Variety::PARTIAL && open.mean > 0)
      spread = std::max(spread, kHidden * open.mean);
  }
  const bool by_ray = counters_.rays > rays_before;
  // What stands on the receiver hides the source from a part of it, or shows it to that part alone.
  const double jump = kJump * largest_factor(open) * tree_->elements[receiver].crossing;
  sight.shadow = std::max(sight.shadow, jump);
  const double shape = stake * sight.misfit, shadow = stake * sight.shadow;
  const double variation = source.sends.detail * spread;
  const double error = std::sqrt(squared(shape) + squared(shadow) + squared(variation));
  const double weighs = weight(receiver, source.sends.radiosity * darkest_row(sight.seen));
  if (error * weighs <= settings_.threshold) {
    if (by_ray && alike(source) * shadow * weighs > settings_.threshold && splits(receiver))
      return descend_receiver(receiver, source, tube);
    if (!parent) verdict_ = verdict(source, sight, open, by_ray, spread, dark, weighs);
    return full_link(receiver, site, source, sight, by_ray);
  }

  const bool source_first = variation > std::max(shape, shadow) ||
                            (shadow > shape && source.site->radius > site.radius) ||
                            source.site->radius > 4 * site.radius;
  if (source_first && descend_source(receiver, site, source, tube)) return;
  if (splits(receiver)) return descend_receiver(receiver, source, tube);
  if (!source_first && descend_source(receiver, site, source, tube)) return;
  full_link(receiver, site, source, sight, by_ray);
}

// Has the element children, or can it be given some?
bool Refiner::splits(std::int32_t receiver) {
  return !tree_->elements[receiver].leaf() || split_leaf(*tree_, receiver, settings_.min_edge);
}

// What many elements of a source get wrong is no less than what few would if it is the same in all:
// a shadow's edge that no node of the receiver sees. Half way between that and errors of any sign.
double Refiner::alike(const Source& source) {
  const double elements = source.patch->head->area / source.patch->elements[source.element].area;
  return std::min(kMostAlike, std::sqrt(std::sqrt(elements)));
}

// Rays that agree are believed as long as little is at stake: where more is, more would be cast.
Verdict Refiner::verdict(const Source& source, const Sight& sight, const Kernel& open, bool by_ray,
                         double spread, double dark, double weighs) {
  const double looked_at = by_ray ? kUnsureFour * open.mean : 0;
  const double missed = std::max(std::hypot(sight.misfit, sight.shadow), looked_at) * weighs;
  return {source.patch_index, static_cast<float>(missed), static_cast<float>(spread * weighs),
          static_cast<float>(dark * missed)};
}

// Of its site, in its patch's frame.
Outline Refiner::outline_of(const Source& source) {
  Outline outline;
  for (const Vec3& p : source.site->polygon())
    outline.push_back(source.patch->head->frame.to_plane(p));
  return outline;
}

// Only a rim of the source is in front of the receiver's plane, and no node of it: rays to those
// behind would go round whatever stands before the rim. The walls of a room were seen from the
// inside of a closed box.
void Refiner::descend_in_front(std::int32_t receiver, const Site& site, const Source& source,
                               const Tube* parent) {
  const Frame& frame = source.patch->head->frame;
  const Line horizon{{dot(site.normal, frame.u), dot(site.normal, frame.v)},
                     dot(site.normal, site.center - frame.origin)};
  const Outline rim = cut(outline_of(source), horizon, 0)[0];
  if (rim.size() < 3 || rim.size() > kMaxOutline) return;
  const Site rim_site = make_site(*source.patch, source.element, rim);
  Source front = source;
  front.in_front = true;
  front.part = source.patch->elements[source.element].leaf();
  front.site = &rim_site;
  descend(receiver, site, front, parent);
}

void Refiner::descend_receiver(std::int32_t receiver, const Source& source, const Tube& tube) {
  ++counters_.splits;
  const std::int32_t child = tree_->elements[receiver].child;
  for (std::int32_t c = child; c < child + 2; ++c) {
    if (!goes_down_to(c)) continue;
    const Site site = make_site(tree_->view(), c);
    if (facing(site, *source.site, settings_.tolerance)) descend(c, site, source, &tube);
  }
}

bool Refiner::descend_source(std::int32_t receiver, const Site& site, const Source& source,
                             const Tube& tube) {
  const Element& x = source.patch->elements[source.element];
  if (!source.part && !x.leaf()) {
    for (std::int32_t c = x.child; c < x.child + 2; ++c) {
      const Site half = make_site(*source.patch, c);
      if (facing(site, half, settings_.tolerance))
        descend(receiver, site, make_source(*source.patch, source.patch_index, c, half), &tube);
    }
    return true;
  }
  // A leaf is cut in parts for better quadrature only: links still lead to the leaf.
  if (source.site->radius < settings_.min_edge || source.site->area < kSmallestPart * x.area)
    return false;
  const Outline outline = outline_of(source);
  const std::array<Outline, 2> parts = halve(outline, moments(outline).centroid);
  if (std::max(parts[0].size(), parts[1].size()) > kMaxOutline) return false;
  for (const Outline& part : parts) {
    if (part.size() < 3) continue;
    Source half = source;
    half.part = true;
    const Site half_site = make_site(*source.patch, source.element, part);
    half.site = &half_site;
    if (facing(site, half_site, settings_.tolerance)) descend(receiver, site, half, &tube);
  }
  return true;
}

void Refiner::full_link(std::int32_t receiver, const Site& site, const Source& source,
                        const Sight& sight, bool by_ray) {
  if (!links(receiver)) return;
  const Ends ends{static_cast<std::uint32_t>(receiver), source.patch_index,
                  static_cast<std::uint32_t>(source.element)};
  if (!(sight.seen.mean > 0)) return note_unseen(ends, sight.variance, *out_);
  const int n = coefficient_count(order_);
  const std::size_t at = out_->couplings.size();
  out_->couplings.resize(at + n * n);
  couple(site, *source.site, sight.seen, order_, std::span(out_->couplings).subspan(at, n * n));
  out_->links.push_back({ends, static_cast<float>(sight.variance)});
  ++counters_.links;
  if (!by_ray) ++counters_.links_without_rays;
}

// One pair of eyes, drawn by a hash of the pair, stands for the whole transfer.
void Refiner::thin_link(std::int32_t receiver, const Site& site, const Source& source) {
  const std::uint32_t hash = mix(mix(tree_->head.patch * 0x9e3779b9u + receiver) ^
                                 mix(source.patch->head->patch * 0x85ebca6bu + source.element));
  thin_link(receiver, source, {site.eye[hash % site.eyes], site.normal},
            {source.site->eye[(hash >> 8) % source.site->eyes], source.site->normal},
            source.site->area);
}

void Refiner::thin_link(std::int32_t receiver, const Source& source, const SurfacePoint& from,
                        const SurfacePoint& to, double source_area) {
  if (!links(receiver)) return;
  const Vec3 d = to.x - from.x;
  const double cx = dot(from.normal, d), cy = -dot(to.normal, d);
  if (cx <= 0 || cy <= 0) return;
  ++counters_.thin_pairs;
  const double d2 = dot(d, d);
  const double coupling = source_area * cx * cy / (d2 * (std::numbers::pi * d2 + source_area));
  waiting_.push_back({{{static_cast<std::uint32_t>(receiver), source.patch_index,
                        static_cast<std::uint32_t>(source.element)},
                       static_cast<float>(coupling)},
                      from.x,
                      to.x,
                      out_});
  if (waiting_.size() == kRayLanes) flush();
}

void Refiner::flush() {
  std::uint16_t blocked = 0;
  if (around_.rays && !waiting_.empty()) {
    SegmentPacket packet;
    for (std::size_t i = 0; i < waiting_.size(); ++i)
      packet.set(static_cast<int>(i), waiting_[i].from, waiting_[i].to);
    counters_.rays += waiting_.size();
    counters_.thin_rays += waiting_.size();
    ++counters_.packets;
    around_.rays->occluded16(packet, blocked);
  }
  for (std::size_t i = 0; i < waiting_.size(); ++i) {
    const Waiting& w = waiting_[i];
    if (blocked >> i & 1) {
      note_unseen(w.link.ends, w.link.doubt(), *w.out);
    } else {
      w.out->thin.push_back(w.link);
      ++counters_.thin_links;
    }
  }
  waiting_.clear();
}

}  // namespace atrium
