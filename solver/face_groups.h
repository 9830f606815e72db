// Face groups at work (engine/face_group.h): planted once from a cluster's patches, filled from
// their light whenever a record is written, looked at by a few of their patches, and what they
// received handed down to those.
//
// Pure functions, any thread.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"
#include "engine/face_group.h"
#include "solver/coupling.h"
#include "solver/gather.h"
#include "solver/push_pull.h"

namespace atrium {

// The groups of a cluster with at least so many patches that may stand for one another, else none.
// Patches are parted by their normals until those of each part lie within a cone, and then, group
// by group, in halves along the longer extent of their centroids. Depth is logarithmic, and the
// same patches in the same order are grouped alike.
GroupTree plant_groups(std::span<const PatchTree> trees, std::size_t least);

// Sets what the groups hold of light.
void pull_groups(std::span<const PatchTree> trees, GroupTree& groups);

// Nodes that stand for a group: one to each quarter of its area.
inline constexpr int kGroupNodes = 4;
static_assert(kGroupNodes <= kMaxNodes && kGroupNodes <= kMaxEyes);

// The members that nodes drawn by this seed lie on.
std::array<std::uint32_t, kGroupNodes> drawn_members(const GroupView& groups, const FaceGroup& g,
                                                     std::uint64_t seed);
// A site without an outline, its nodes points of those members' roots by the same seed: pairs draw
// their own, so that what one pair of nodes gets wrong the next does not.
Site make_site(const FaceGroup& g, std::span<const PatchView, kGroupNodes> drawn,
               std::uint64_t seed);

// What groups gathered becomes part of what their patches did. slots, means: of the patches, then
// of the groups.
void push_groups(const GroupView& groups, std::span<const PatchTree> trees,
                 std::span<GatherSlots> slots, std::span<RowMean> means);

}  // namespace atrium
