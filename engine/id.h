// Typed indices: records point at each other by index, never by address, and a cluster's index
// cannot be handed to where a patch's is wanted.
#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <limits>

namespace atrium {

template <class Tag>
struct Id {
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t value = kNone;

  constexpr Id() = default;
  constexpr explicit Id(std::uint32_t v) : value(v) {}
  constexpr explicit Id(std::size_t v) : value(static_cast<std::uint32_t>(v)) {}
  constexpr bool valid() const { return value != kNone; }
  friend constexpr auto operator<=>(const Id&, const Id&) = default;
};

using MaterialId = Id<struct MaterialTag>;
using ObjectId = Id<struct ObjectTag>;    // a group of the modelling hierarchy
using SurfaceId = Id<struct SurfaceTag>;  // a planar convex polygon of the scene
using PatchId = Id<struct PatchTag>;      // one side of a piece of a surface: an element tree's root
using ClusterId = Id<struct ClusterTag>;
using CellId = Id<struct CellTag>;
using PortalId = Id<struct PortalTag>;

}  // namespace atrium

template <class Tag>
struct std::hash<atrium::Id<Tag>> {
  std::size_t operator()(const atrium::Id<Tag>& id) const noexcept { return id.value; }
};
