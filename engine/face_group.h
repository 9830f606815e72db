// Face groups: levels of detail above patches. The small patches of a dense cluster that look about
// the same way stand for one another where they are far or weigh little: a binary tree whose leaves
// are patches and whose nodes are groups of them. A group sends the mean of its patches' radiosity
// and receives one irradiance for all. [face clusters: Willmott, Heckbert & Garland 99; α links:
// Smits, Arvo & Greenberg 94]
//
// Invariants:
//  1. A group's members are a run of GroupMember, its children's runs one after the other; a group
//     stands before the groups in it.
//  2. Members neither emit nor are inert, and each is less than kLargeShare of its cluster: all
//     are in one unit of the coarse system (scheduler/equilibrium.h).
// Plain data, as records hold it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "engine/spectrum.h"
#include "engine/vec.h"

namespace atrium {

// A patch that is at least this share of its cluster stands for itself.
inline constexpr double kLargeShare = 1.0 / 16;

struct FaceGroup {
  double area = 0;               // m², of its members
  Vec3 center{0};                // of a ball that holds them
  double radius = 0;             // m
  Vec3 axis{0};                  // unit
  double cone = 0;               // rad: no member's normal is farther off the axis
  Spectrum reflectance{0};       // mean
  Spectrum radiosity{0};         // lm/m², mean
  double detail = 0;             // lm/m², root mean square of what that leaves out, luminance
  double irradiance = 0;         // lx, mean, luminance
  double irradiance_detail = 0;  // lx, root mean square about it
  std::array<std::int32_t, 2> child{0, 0};  // a group; ~patch, local to the cluster: a patch
  std::uint32_t first_member = 0, member_count = 0;
  std::uint32_t inner = 0;  // 1: part of another group
  std::uint32_t reserved = 0;
};
static_assert(std::is_trivially_copyable_v<FaceGroup> && sizeof(FaceGroup) == 168);

struct GroupMember {
  double area_before = 0;   // m², of all members before it
  std::uint32_t patch = 0;  // local to the cluster
  std::uint32_t reserved = 0;
};
static_assert(std::is_trivially_copyable_v<GroupMember> && sizeof(GroupMember) == 16);

// A cluster's groups, wherever they live.
struct GroupView {
  std::span<const FaceGroup> groups;
  std::span<const GroupMember> members;

  std::span<const GroupMember> members_of(const FaceGroup& g) const {
    return members.subspan(g.first_member, g.member_count);
  }
  // A patch for all: they share a unit of the coarse system.
  std::uint32_t any_patch(const FaceGroup& g) const { return members[g.first_member].patch; }
};

struct GroupTree {
  std::vector<FaceGroup> groups;
  std::vector<GroupMember> members;

  GroupView view() const { return {groups, members}; }
  std::size_t bytes() const {  // in a record
    return groups.size() * sizeof(FaceGroup) + members.size() * sizeof(GroupMember);
  }
};

}  // namespace atrium
