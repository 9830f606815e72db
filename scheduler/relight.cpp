#include "scheduler/relight.h"

#include <algorithm>

#include "engine/check.h"
#include "solver/face_groups.h"

namespace atrium {

namespace {

std::size_t mend_count(const PatchView& patch) {
  if (patch.head->inert) return 0;
  return std::size_t(std::ranges::count_if(patch.elements, &Element::leaf)) *
         std::size_t(patch.k());
}

// E as it becomes, on the leaves: what push_pull pulls up from.
GatherSlots filled(const PatchTree& tree, std::span<const Spectrum> mends) {
  const std::size_t k = std::size_t(tree.view().k());
  GatherSlots slots;
  slots.reset(tree.elements.size(), int(k));
  std::size_t at = 0;  // in mends
  for (std::size_t i = 0; i < tree.elements.size(); ++i) {
    if (!tree.elements[i].leaf()) continue;
    double* g = &slots.g[i * k * kGatherChannels];
    for (std::size_t a = 0; a < k; ++a)
      for (int c = 0; c < kChannels; ++c) {
        double& to = g[a * kGatherChannels + std::size_t(c)];
        to = tree.e[(i * k + a) * kChannels + std::size_t(c)];
        if (!mends.empty()) to += mends[at + a][c];
      }
    at += k;
    g[kRowSum] = 1 - std::max(0.0, tree.head.escape);
    for (int c = 0; c < kChannels; ++c)
      if (g[c] < 0)
        for (std::size_t a = 0; a < k; ++a) g[a * kGatherChannels + std::size_t(c)] = 0;
  }
  return slots;
}

}  // namespace

std::size_t mend_count(const ClusterView& cluster) {
  std::size_t count = 0;
  for (std::size_t p = 0; p < cluster.size(); ++p) count += mend_count(cluster.patch(p));
  return count;
}

PushPullSums relight(PatchTree& tree, const PlacedLight& light, std::size_t patch,
                     std::span<const Spectrum> mends, std::span<PlaceGain> gains) {
  ATRIUM_CHECK(mends.empty() || mends.size() == mend_count(tree.view()));
  add_placed(tree, light, patch);
  GatherSlots slots = filled(tree, mends);
  return push_pull(tree, slots, Closing{}, 1, gains);
}

Relit relight(const ClusterView& before, ClusterEdit& record, const PlacedLight& light,
              std::span<const Spectrum> mends) {
  const std::uint32_t cluster = before.head().cluster;
  std::vector<PatchTree> trees = read_record(before);
  GroupTree groups = read_groups(before);
  Relit relit;
  relit.gains.resize(trees.size());
  for (std::size_t p = 0; p < trees.size(); ++p) {
    relit.elements += trees[p].elements.size();
    if (trees[p].head.inert) continue;
    const std::size_t own = mends.empty() ? 0 : mend_count(trees[p].view());
    PatchGain& gain = relit.gains[p];
    gain.places.resize(light.by_place(p).size());
    const PushPullSums sums = relight(trees[p], light, p, mends.first(own), gain.places);
    mends = mends.subspan(own);
    relit.sums.add(sums);
    gain.gained = sums.gained;
    gain.beyond = sums.beyond;
  }
  pull_groups(trees, groups);
  write_record(cluster, trees, record.bytes(), groups);
  return relit;
}

}  // namespace atrium
