// What a pair's ends see of each other: by the tube between them, by rays, or measured exactly
// where few blockers stand between. And how far what was seen may be wrong. (Refiner, refine.h)
#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/squared.h"
#include "solver/pair_terms.h"
#include "solver/refine.h"

namespace atrium {

namespace {

// Blockers up to which what is seen past them is measured instead of sampled.
constexpr std::size_t kFewBlockers = 8;
// Transfers that sixteen rays may leave in error by more than so many thresholds are measured.
constexpr double kHeavy = 4;
// Root mean square error that the nodes leave of what is measured from them, relative to how it
// varies from node to node: twice what it was found to be in the Cornell box and in rooms.
constexpr double kSmooth = 0.1;

// Variance of the share seen from the receiver's nodes.
double variance_over_rows(const Site& r, const Kernel& open, const Kernel& seen) {
  const double v = seen.mean / open.mean;
  double sum = 0;
  for (int k = 0; k < open.rows; ++k)
    if (open.row[k] > 0) sum += r.weight[k] * squared(seen.row[k] / open.row[k] - v);
  return sum;
}

// Sixteen points spread over a site by a sequence of low discrepancy. [Roberts 2018, R2]
void spread(const Site& site, double shift, std::span<Vec3, kRayLanes> out) {
  constexpr double kPlastic1 = 0.7548776662466927, kPlastic2 = 0.5698402909980532;
  const std::span<const Vec3> v = site.polygon();
  double whole = 0;
  for (std::size_t t = 2; t < v.size(); ++t) whole += length(cross(v[t - 1] - v[0], v[t] - v[0]));
  for (int i = 0; i < kRayLanes; ++i) {
    const double a = (i + shift) * kPlastic1, b = (i + shift) * kPlastic2;
    double at = (a - std::floor(a)) * whole;  // along the fan of triangles round the first vertex
    for (std::size_t t = 2; t < v.size(); ++t) {
      const double part = length(cross(v[t - 1] - v[0], v[t] - v[0]));
      if (at > part && t + 1 < v.size()) {
        at -= part;
        continue;
      }
      const double r = std::sqrt(std::min(1.0, at / part)), s = b - std::floor(b);
      out[i] = v[0] + r * ((1 - s) * (v[t - 1] - v[0]) + s * (v[t] - v[0]));
      break;
    }
  }
}

}  // namespace

// 3(c) T = Tube(R, S, B(R, S)), here of a pair on its way down. [THFH94 §5.1]
Variety Refiner::draw(Tube& tube, const Tube* parent, const Site& r, const Site& s) {
  const PolygonPair ends{r.polygon(), r.normal, s.polygon(), s.normal};
  const BlockerIndex& index = *around_.index;
  tube = parent ? subdivide(*parent, ends, index, settings_.tolerance)
                : make_tube(ends, index, settings_.tolerance);
  const Variety v = variety(tube, ends, index, settings_.tolerance);
  ++(v == Variety::VISIBLE     ? counters_.tubes_visible
     : v == Variety::INVISIBLE ? counters_.tubes_invisible
                               : counters_.tubes_partial);
  return v;
}

// Of a transfer so heavy that what sixteen rays leave open may be too much the blockers are asked
// for: past few it is measured. Other transfers, most of them, take sixteen rays: a tube past a
// room's furniture costs as much as twenty such packets, and what it could add is far below their
// threshold.
Variety Refiner::look_through(Tube& tube, const Tube* parent, std::int32_t receiver,
                              const Site& site, const Source& source, const Kernel& open,
                              bool goes_down, Sight& sight) {
  if (!(open.mean > 0) || (parent && inherits(*parent)))
    return draw(tube, parent, site, *source.site);
  const double transfer = source.sends.radiosity * open.mean;
  const bool heavy = kMixed * transfer * weight(receiver, 0) > kHeavy * settings_.threshold;
  if (goes_down) return glance(tube, parent, receiver, site, source, open, heavy, sight);
  if (!heavy) {
    tube = skip_tube(parent);
    sight = see(receiver, site, source, open, seen_by_rays(site, *source.site, open));
    return Variety::PARTIAL;
  }
  const Variety v = draw(tube, parent, site, *source.site);
  if (v == Variety::PARTIAL && !measure(receiver, site, source, open, tube, sight))
    sight = see(receiver, site, source, open, seen_by_rays(site, *source.site, open));
  return v;
}

// What goes down for its shape in any case is asked with one packet whether any of it is seen, and
// for its blockers only where none is; but the patches themselves are asked for theirs first, for
// if there are none all below is known.
Variety Refiner::glance(Tube& tube, const Tube* parent, std::int32_t receiver, const Site& site,
                        const Source& source, const Kernel& open, bool heavy, Sight& sight) {
  if (heavy && !parent) {
    const Variety v = draw(tube, parent, site, *source.site);
    if (v != Variety::PARTIAL) return v;
  }
  const Kernel seen = seen_by_rays(site, *source.site, open);
  if (!heavy || (parent && seen.mean > 0)) {
    tube = skip_tube(parent);
  } else if (parent && draw(tube, parent, site, *source.site) == Variety::INVISIBLE) {
    return Variety::INVISIBLE;
  }
  if (seen.mean > 0) {
    const double v = seen_share(site, open, seen);
    sight.seen = seen;
    sight.shadow = kMixed * std::sqrt(v * (1 - v)) * open.mean;
    sight.variance += variance_of(open.mean, v);
  } else if (!heavy || !measure(receiver, site, source, open, tube, sight)) {
    sight = see(receiver, site, source, open, seen);
  }
  return Variety::PARTIAL;
}

// A pair that is taken to be partly seen.
Tube Refiner::skip_tube(const Tube* parent) {
  ++counters_.tubes_partial;
  return undrawn(parent);
}

// What sixteen rays say of a pair that is not wholly seen; sixteen more where they agree and much
// is at stake.
Refiner::Sight Refiner::see(std::int32_t receiver, const Site& site, const Source& source,
                            const Kernel& open, const Kernel& seen) {
  const double transfer = source.sends.radiosity * open.mean;
  double v = seen_share(site, open, seen);
  const double arriving = source.sends.radiosity * darkest_row(seen);
  if ((v == 0 || v == 1) &&
      kUnsureFour * alike(source) * transfer * weight(receiver, arriving) > settings_.threshold)
    v = 0.5 * (v + scattered_share(site, *source.site));
  Sight sight;
  sight.seen = seen;
  sight.misfit = v > 0 ? misfit(receiver, site, seen) : 0;
  sight.shadow = std::max(kUnsure * (open.mean + misfit(receiver, site, open)),
                          kMixed * std::sqrt(v * (1 - v)) * open.mean);
  sight.variance = squared(kUnsureShape * open.mean) + variance_of(open.mean, v);
  return sight;
}

// What the receiver's nodes see of the source, exactly, where few stand between; false where that
// is not to be had. What a node sees of a source's parts adds up to what it sees of the whole, so
// that what links from them get wrong evens out along a shadow's edge. Where some went by what the
// source's nodes see of the receiver, whichever end's share varied less, it did not: under a beam
// below a lamp leaves were 2% too dark and too bright in turn, by links that each did as they may.
// That view only says how well the nodes do.
bool Refiner::measure(std::int32_t receiver, const Site& r, const Source& source,
                      const Kernel& open, const Tube& tube, Sight& sight) const {
  if (tube.crowded || tube.count > kFewBlockers) return false;
  const Site& s = *source.site;
  const BlockerList blockers{tube.list(), around_.index->blockers(), settings_.tolerance};
  const std::optional<Kernel> seen = seen_by_receiver(r, s, open, blockers);
  if (!seen) return false;
  const std::optional<Kernel> by_source = seen_by_source(r, s, open, blockers);
  if (!by_source) return false;
  const double apart = seen->mean - by_source->mean;
  const double rough = squared(open.mean) * variance_over_rows(r, open, *seen);
  sight.seen = *seen;
  sight.misfit = misfit(receiver, r, *seen);
  sight.shadow = std::sqrt(squared(apart) + squared(kSmooth) * rough);
  sight.variance = squared(kUnsureShape * open.mean) + squared(apart) + rough;
  return true;
}

// The share of sixteen segments between points of their own that nothing blocks.
double Refiner::scattered_share(const Site& receiver, const Site& source) {
  constexpr double kShift = 0.5, kOtherShift = 8.25;  // so that ends are paired without a pattern
  std::array<Vec3, kRayLanes> from, to;
  spread(receiver, kShift, from);
  spread(source, kOtherShift, to);
  SegmentPacket packet;
  for (int i = 0; i < kRayLanes; ++i) {
    const Vec3 d = to[i] - from[i];
    if (dot(receiver.normal, d) > 0 && dot(source.normal, d) < 0) packet.set(i, from[i], to[i]);
  }
  if (packet.valid == 0) return 0;
  counters_.rays += std::popcount(packet.valid);
  ++counters_.packets;
  std::uint16_t blocked = 0;
  around_.rays->occluded16(packet, blocked);
  return double(std::popcount(std::uint16_t(packet.valid & ~blocked))) /
         std::popcount(packet.valid);
}

// What a packet between their eyes leaves of the kernel.
Kernel Refiner::seen_by_rays(const Site& receiver, const Site& source, const Kernel& open) {
  const VisibleMask lanes = facing_lanes(receiver, source, open);
  SegmentPacket packet;
  for (int left = lanes; left != 0; left &= left - 1) {
    const int i = std::countr_zero(unsigned(left));
    packet.set(i, receiver.eye[i / kMaxEyes], source.eye[i % kMaxEyes]);
  }
  counters_.rays += std::popcount(lanes);
  ++counters_.packets;
  std::uint16_t blocked = 0;
  around_.rays->occluded16(packet, blocked);
  return masked(receiver, source, open, lanes, VisibleMask(lanes & ~blocked));
}

}  // namespace atrium
