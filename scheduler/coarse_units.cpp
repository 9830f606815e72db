#include "scheduler/coarse_units.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace atrium {

namespace {

// Entries of K for a pair of clusters that may see each other: half of that in gen floor and
// building.
constexpr double kEntriesOfPair = 3;
// Units are divided into so many on average at the most: more save no sweep in a single room. And
// only as far as K has no more than so many entries by it, which take about as long as the gathers
// of a sweep over sixteen rooms.
constexpr double kMostParts = 8;
constexpr double kMostEntries = 600'000;

// m², of what takes part in the exchange of light.
double lit_area(const Model& model, std::uint32_t patch) {
  return model.patches[patch].inert ? 0 : area(model.polygon(model.patches[patch]));
}

double lit_area(const Model& model, const Cluster& c) {
  double sum = 0;
  for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
    sum += lit_area(model, p);
  return sum;
}

// Of a patch on average; below 2 none is divided.
double parts_of_unit(const Model& model, Division division) {
  if (division == Division::kNone) return 1;
  const double undivided = undivided_entries(model);
  return undivided > 0 ? std::min(kMostParts, std::sqrt(kMostEntries / undivided)) : 1;
}

// By patch: its area where it is a unit of its own, else 0.
std::vector<double> areas_apart(const Model& model) {
  std::vector<double> areas(model.patches.size(), 0);
  for (const Cluster& c : model.clusters) {
    const double least = kLargeShare * lit_area(model, c);
    for (std::uint32_t p = c.first_patch; p < c.first_patch + c.patch_count; ++p)
      if (const double own = lit_area(model, p);
          own > 0 && (own >= least || model.patches[p].footprint))
        areas[p] = own;
  }
  return areas;
}

// m², about which a part has: as all of them together would have if they were equal.
double area_of_part(std::span<const double> apart, double parts) {
  constexpr double kFewest = 2;
  double all = 0, count = 0;
  for (const double a : apart) all += a, count += a > 0;
  return parts < kFewest || count == 0 ? std::numeric_limits<double>::infinity()
                                       : all / (parts * count);
}

int depth_of(double patch, double part) {
  return patch > part ? std::min(std::ilogb(patch / part), kPlaceDepth) : 0;
}

// A leaf that is larger than a part has gained the same share in all that it holds.
PlaceGain gain_of_part(std::span<const PlaceGain> places, std::size_t part) {
  PlaceGain sum;
  double share = 1;
  for (std::size_t q = places.size() / 2 + part; q > 0; q /= 2, share /= 2)
    sum.add({share * places[q].area, share * places[q].gained, share * places[q].beyond});
  return sum;
}

}  // namespace

CoarseUnits::CoarseUnits(const Model& model, Division division)
    : unit_of_patch_(model.patches.size()) {
  const std::vector<double> apart = areas_apart(model);
  const double part = area_of_part(apart, parts_of_unit(model, division));
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c) {
    const Cluster& cluster = model.clusters[c];
    first_patch_.push_back(cluster.first_patch);
    first_unit_.push_back(std::uint32_t(size()));
    std::uint32_t slots = 0;
    const auto add_units = [&](double area, int depth) {
      const auto first = std::uint32_t(size()), count = std::uint32_t(1) << depth;
      areas_.resize(first + count, area / count);
      cluster_.resize(size(), c);
      first_part_.resize(size(), first);
      first_slot_.resize(size(), slots);
      depth_.resize(size(), std::uint8_t(depth));
      slots += 2 * count - 1;
      return first;
    };
    const std::uint32_t rest = add_units(0, 0);
    for (std::uint32_t p = cluster.first_patch; p < cluster.first_patch + cluster.patch_count;
         ++p) {
      unit_of_patch_[p] = apart[p] > 0 ? add_units(apart[p], depth_of(apart[p], part)) : rest;
      if (!(apart[p] > 0)) areas_[rest] += lit_area(model, p);
    }
  }
  first_patch_.push_back(std::uint32_t(model.patches.size()));
  first_unit_.push_back(std::uint32_t(size()));
}

std::span<const std::uint32_t> CoarseUnits::of(ClusterId cluster) const {
  const std::uint32_t first = first_patch_[cluster.value];
  return std::span(unit_of_patch_).subspan(first, first_patch_[cluster.value + 1] - first);
}

std::size_t CoarseUnits::slots(ClusterId cluster) const {
  const std::size_t last = end(cluster) - 1;
  return first_slot_[last] + 2 * parts(last) - 1;
}

std::vector<double> CoarseUnits::place_areas(std::uint32_t first) const {
  const std::size_t n = parts(first);
  std::vector<double> areas(2 * n);
  for (std::size_t i = 0; i < n; ++i) areas[n + i] = areas_[first + i];
  for (std::size_t q = n - 1; q > 0; --q) areas[q] = areas[2 * q] + areas[2 * q + 1];
  return areas;
}

std::vector<PlaceGain> CoarseUnits::gains(ClusterId cluster, std::span<const PatchGain> patches) {
  std::vector<PlaceGain> gains(end(cluster) - first(cluster));
  const std::span<const std::uint32_t> units = of(cluster);
  for (std::size_t p = 0; p < units.size(); ++p) {
    PlaceGain* const own = &gains[units[p] - first(cluster)];
    if (!divided(units[p])) {
      own->add({0, patches[p].gained, patches[p].beyond});
      continue;
    }
    for (std::size_t i = 0; i < parts(units[p]); ++i) {
      own[i] = gain_of_part(patches[p].places, i);
      areas_[units[p] + i] = own[i].area;
    }
  }
  return gains;
}

PlacedLight CoarseUnits::placed(ClusterId cluster, std::span<const Spectrum> by_unit) const {
  PlacedLight light;
  std::vector<Spectrum> by_place;
  for (const std::uint32_t u : of(cluster)) {
    if (!divided(u)) {
      light.add_patch(by_unit[u]);
      continue;
    }
    const std::size_t n = parts(u);
    const std::vector<double> areas = place_areas(u);
    by_place.assign(2 * n, Spectrum{0});
    for (std::size_t i = 0; i < n; ++i) by_place[n + i] = by_unit[u + i];
    for (std::size_t q = n - 1; q > 0; --q)
      by_place[q] =
          (areas[2 * q] * by_place[2 * q] + areas[2 * q + 1] * by_place[2 * q + 1]) / areas[q];
    light.add_patch(by_place[1], by_place);
  }
  return light;
}

std::size_t CoarseUnits::bytes() const {
  constexpr std::size_t kByUnit =
      sizeof(double) + 3 * sizeof(std::uint32_t) + sizeof(std::uint8_t);
  return size() * kByUnit +
         (unit_of_patch_.size() + 2 * first_patch_.size()) * sizeof(std::uint32_t);
}

double undivided_entries(const Model& model) {
  return kEntriesOfPair * double(model.visible.items.size());
}

}  // namespace atrium
