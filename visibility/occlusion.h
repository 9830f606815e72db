// RayScene: point-to-point visibility among the polygons of a working set, by rays. Embree behind
// it, of which nothing shows here.
//
// Invariants:
//  1. Embree computes in float: positions are moved to the centre of the polygons and scaled by a
//     power of two to an extent in [1, 2) first, so that 1e6 m off the origin or rooms of 1e-6 m
//     lose nothing they had.
//  2. A hit that float reports is held against the polygon's plane in double. So a segment is never
//     blocked by a polygon in whose plane it starts or ends, however flat it leaves it, a ray never
//     hits one in whose plane it starts, and t is good to double.
//  3. The same polygons in the same order give the same answers for any number of threads, and the
//     scene is built by the calling thread alone.
// Immutable once built; any number of threads may query.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "engine/vec.h"
#include "visibility/blocker.h"

namespace atrium {

inline constexpr int kRayLanes = 16;

// What counts as the surface at a segment's end: crossings nearer to it than this share of the
// scene's extent plus of the segment's length. Ten times what float leaves of a coordinate.
inline constexpr double kEndShrink = 1e-6;

// Up to 16 segments between surface points; lanes outside `valid` are not looked at.
struct SegmentPacket {
  using Lanes = std::array<double, kRayLanes>;
  Lanes from_x{}, from_y{}, from_z{};  // m
  Lanes to_x{}, to_y{}, to_z{};
  std::uint16_t valid = 0;

  void set(int lane, const Vec3& from, const Vec3& to) {
    from_x[lane] = from.x, from_y[lane] = from.y, from_z[lane] = from.z;
    to_x[lane] = to.x, to_y[lane] = to.y, to_z[lane] = to.z;
    valid = static_cast<std::uint16_t>(valid | 1u << lane);
  }
};

// Up to 16 rays; `near` is the distance in metres before which nothing is hit.
struct RayPacket {
  using Lanes = std::array<double, kRayLanes>;
  Lanes x{}, y{}, z{};     // origin, m
  Lanes dx{}, dy{}, dz{};  // direction, of any length but zero
  Lanes near{};
  std::uint16_t valid = 0;
  bool coherent = false;  // they start near one another and go much the same way: a hint

  void set(int lane, const Vec3& origin, const Vec3& direction, double tnear) {
    x[lane] = origin.x, y[lane] = origin.y, z[lane] = origin.z;
    dx[lane] = direction.x, dy[lane] = direction.y, dz[lane] = direction.z;
    near[lane] = tnear;
    valid = static_cast<std::uint16_t>(valid | 1u << lane);
  }
};

struct Hit {
  std::uint32_t id = 0;  // of the BlockerPolygon
  double t = 0;          // m along the ray
  Vec3 point{0};
  Vec3 normal{0};  // unit, of the polygon's front: the ray comes from behind where it points along
};

struct HitPacket {
  std::array<Hit, kRayLanes> hit;
  std::uint16_t found = 0;  // the lanes that hit anything
};

class RayScene {
 public:
  // The polygons are copied. Those without area block nothing.
  explicit RayScene(std::span<const BlockerPolygon> polygons);
  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  // The lanes of `segments` that something blocks. Coordinates must be finite.
  void occluded16(const SegmentPacket& segments, std::uint16_t& blocked_mask) const;
  bool occluded(const Vec3& from, const Vec3& to) const;

  // The first polygon from either side at t >= tnear.
  std::optional<Hit> closest_hit(const Vec3& origin, const Vec3& direction, double tnear) const;
  void closest_hit16(const RayPacket& rays, HitPacket& hits) const;

  // Memory held, Embree's own included.
  std::size_t bytes() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace atrium
