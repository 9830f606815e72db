#include "scheduler/orders/gather_sets.h"

#include <algorithm>
#include <numeric>

namespace atrium {

namespace {

// A patch and its root element, their corners and coefficients.
constexpr double kFirstBytesAPatch = 500;
// What all records grow by, over what they begin with: so much at an error of 10%.
constexpr double kGrowth = 5;
// Records looked at to compare sets: above it they are compared by samples. A second of work.
constexpr double kMostLooks = 4e8;

std::vector<double> guess_bytes(const Model& model) {
  std::vector<double> area_of(model.clusters.size(), 0);
  for (const Patch& p : model.patches)
    if (!p.inert) area_of[p.cluster.value] += area(model.polygon(p));
  const double all = std::accumulate(area_of.begin(), area_of.end(), 0.0);
  const double a_square_metre =
      all > 0 ? kGrowth * kFirstBytesAPatch * double(model.patches.size()) / all : 0;
  std::vector<double> bytes;
  for (std::size_t c = 0; c < area_of.size(); ++c)
    bytes.push_back(kFirstBytesAPatch * model.clusters[c].patch_count +
                    a_square_metre * area_of[c]);
  return bytes;
}

// Visible lists hold a cluster itself only where it lights itself; a gather reads it at any rate.
Rows<std::uint32_t> find_sets(const Model& model) {
  Rows<std::uint32_t> sets;
  std::vector<std::uint32_t> set;
  for (std::uint32_t c = 0; c < model.clusters.size(); ++c) {
    set.assign(1, c);
    for (const ClusterId s : model.visible[c])
      if (s.value != c) set.push_back(s.value);
    std::sort(set.begin(), set.end());
    sets.push_row(set);
  }
  return sets;
}

std::uint32_t mixed(std::uint32_t x) {  // [Wellons, "Prospecting for Hash Functions", 2018]
  x = (x ^ (x >> 16)) * 0x7feb352du;
  x = (x ^ (x >> 15)) * 0x846ca68bu;
  return x ^ (x >> 16);
}

// The share of all records with which comparing takes no more than kMostLooks.
double share_to_compare(const Model& model, const Rows<std::uint32_t>& sets) {
  double looks = 0;
  for (std::size_t c = 0; c < sets.size(); ++c)
    for (const ClusterId s : model.visible[c]) looks += double(sets[s.value].size());
  return std::min(1.0, kMostLooks / std::max(looks, 1.0));
}

Rows<std::uint32_t> sampled(const Rows<std::uint32_t>& sets, double share) {
  const auto limit = std::uint64_t(share * 0x1p32);
  Rows<std::uint32_t> rows;
  std::vector<std::uint32_t> row;
  for (std::size_t c = 0; c < sets.size(); ++c) {
    row.clear();
    for (const std::uint32_t r : sets[c])
      if (mixed(r) < limit) row.push_back(r);
    rows.push_row(row);
  }
  return rows;
}

Rows<GatherSets::Neighbor> find_neighbors(const Model& model, const GatherSets& g) {
  std::vector<double> whole(g.size(), 0), here(g.size(), 0);
  for (std::size_t c = 0; c < g.size(); ++c)
    for (const std::uint32_t r : g.compared[c]) whole[c] += g.bytes[r];
  Rows<GatherSets::Neighbor> neighbors;
  std::vector<GatherSets::Neighbor> row;
  for (std::uint32_t c = 0; c < g.size(); ++c) {
    for (const std::uint32_t r : g.compared[c]) here[r] = g.bytes[r];
    row.clear();
    for (const ClusterId s : model.visible[c]) {
      if (s.value == c) continue;
      double common = 0;
      for (const std::uint32_t r : g.compared[s.value]) common += here[r];
      row.push_back({s.value, float((whole[c] + whole[s.value] - 2 * common) / g.share)});
    }
    neighbors.push_row(row);
    for (const std::uint32_t r : g.compared[c]) here[r] = 0;
  }
  return neighbors;
}

}  // namespace

GatherSets find_gather_sets(const Model& model, bool with_neighbors) {
  GatherSets g;
  g.bytes = guess_bytes(model);
  g.sets = find_sets(model);
  g.share = share_to_compare(model, g.sets);
  g.compared = sampled(g.sets, g.share);
  if (with_neighbors) g.neighbors = find_neighbors(model, g);
  return g;
}

double distance(const GatherSets& gathers, std::uint32_t a, std::uint32_t b) {
  const auto x = gathers.compared[a], y = gathers.compared[b];
  double sum = 0;
  for (std::size_t i = 0, j = 0; i < x.size() || j < y.size();) {
    const bool in_x = i < x.size() && (j == y.size() || x[i] <= y[j]);
    const bool in_y = j < y.size() && (i == x.size() || y[j] <= x[i]);
    if (in_x != in_y) sum += gathers.bytes[in_x ? x[i] : y[j]];
    i += in_x;
    j += in_y;
  }
  return sum / gathers.share;
}

std::uint32_t arena_reach(std::size_t gathers) {
  return std::max(1u, static_cast<std::uint32_t>(gathers / 3));
}

double likely_bytes(const GatherSets& gathers, std::span<const ClusterId> order) {
  constexpr std::int64_t kNever = -1;
  const auto n = static_cast<std::int64_t>(order.size());
  const std::int64_t reach = arena_reach(order.size());
  std::vector<std::int64_t> first(gathers.size(), kNever), last(gathers.size(), kNever);
  double sum = 0;
  for (std::int64_t t = 0; t < n; ++t)
    for (const std::uint32_t r : gathers.sets[order[std::size_t(t)].value]) {
      if (last[r] == kNever) {
        first[r] = t;
      } else {
        sum += gathers.bytes[r] * double(std::min(reach, t - last[r]));
      }
      last[r] = t;
    }
  for (std::size_t r = 0; r < gathers.size(); ++r)
    if (last[r] != kNever)
      sum += gathers.bytes[r] * double(std::min(reach, n - last[r] + first[r]));
  return sum / double(reach);
}

}  // namespace atrium
