// Coupling coefficients between two elements: the kernel cosθ cosθ' / πr² at the nodes of both
// [GSCH93 quadrature], each receiver node's row scaled to the exact configuration factor where the
// source is near, and visibility entered node pair by node pair, or by what each node sees of the
// other end, never as a mean times a mean.
//
// Pure functions, any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "engine/cluster_record.h"
#include "solver/basis.h"
#include "visibility/seen_part.h"

namespace atrium {

// A site is looked at from so many points at the most: 16 segments between two, a packet.
inline constexpr int kMaxEyes = 4;

// A place that sends or receives: an element, or a convex part of one, with its nodes in space; or
// a group of faces (solver/face_groups.h), which has no outline, its `normal` only an axis. Basis
// values are those of the element, wherever the part lies in it; a group has its mean alone.
struct Site {
  std::array<Vec3, kMaxNodes> x;
  std::array<Vec3, kMaxNodes> n;         // unit, at the nodes
  std::array<double, kMaxNodes> weight;  // sums to 1
  std::array<BasisValues, kMaxNodes> phi;
  // What a value at a node is multiplied with, and the weight, for its part in the means of value
  // × φ; exact where the values are those of a function of the basis. Set where that is not phi.
  std::array<BasisValues, kMaxNodes> dual;
  bool own_dual = false;
  int nodes = 0;
  // Ends of the segments that are looked along: the nodes that order 2 has.
  std::array<Vec3, kMaxEyes> eye;
  int eyes = 0;
  Vec3 normal{0};
  Vec3 center{0};
  double area = 0;
  double radius = 0;
  std::array<Vec3, kMaxOutline> outline;
  int vertices = 0;

  double cubic_seen = 1, bowl = 0;  // Rule's

  std::span<const Vec3> polygon() const { return {outline.data(), std::size_t(vertices)}; }
  const BasisValues& test(int node) const { return own_dual ? dual[node] : phi[node]; }
  bool looks_from_nodes() const { return eyes == nodes; }
  bool group() const { return vertices == 0; }
  const Vec3& eye_normal(int k) const { return group() ? n[k] : normal; }
};

// The site of a part of element i given by its outline in the patch's frame.
Site make_site(const PatchView& patch, std::size_t i, std::span<const Vec2> part);
inline Site make_site(const PatchView& patch, std::size_t i) {
  return make_site(patch, i, patch.polygon(patch.elements[i]));
}

// The point of a site next to x.
Vec3 nearest_point(const Site& site, const Vec3& x);

// The configuration factor at a point of the receiver that no fixed node need be near.
struct Probe {
  double factor = 0;
  Vec3 at{0};
  double area = 0;  // m², about so much of the receiver's plane it stands for
};

// Row k, column l: share of the light that source node l's part of the source sends to receiver
// node k; a row sums to the configuration factor of the source there. Unoccluded.
struct Kernel {
  std::array<std::array<double, kMaxNodes>, kMaxNodes> g;
  std::array<double, kMaxNodes> row;
  double center = 0;  // configuration factor at the receiver's centre
  // The same next to the source, where it may be largest, and at the corner farthest from it: a
  // lamp a little below a ceiling lights a spot with a narrow rim. Of close pairs only.
  std::array<Probe, 2> probes;
  int probe_count = 0;
  double mean = 0;  // form factor receiver → source
  int rows = 0, columns = 0;
  // To some receiver node all of the source's are behind its plane, though part of it is in front:
  // g gives its light to nodes that cannot be looked at.
  bool behind = false;
};
Kernel make_kernel(const Site& receiver, const Site& source);

// Bit 4k+l: is receiver eye k seen from source eye l?
using VisibleMask = std::uint16_t;
constexpr VisibleMask lane(int k, int l) { return VisibleMask(1u << (kMaxEyes * k + l)); }

// The eye pairs that face each other.
VisibleMask facing_lanes(const Site& receiver, const Site& source, const Kernel& open);

// The kernel with what is not visible left out, node pair by node pair. Where eyes are not nodes, a
// pair of nodes sees the share that the eyes about them do.
Kernel masked(const Site& receiver, const Site& source, const Kernel& open, VisibleMask looked,
              VisibleMask visible);

// The kernel as the listed blockers leave it, measured without a ray: from each node of one end the
// seen part of the other is cut out, and its form factor given to the other's nodes so that its
// centroid is kept. The probes stay unoccluded. Nothing where a part falls into too many pieces.
std::optional<Kernel> seen_by_receiver(const Site& receiver, const Site& source, const Kernel& open,
                                       const BlockerList& blockers);
std::optional<Kernel> seen_by_source(const Site& receiver, const Site& source, const Kernel& open,
                                     const BlockerList& blockers);

// Writes K×K coefficients, row: receiver's function.
void couple(const Site& receiver, const Site& source, const Kernel& kernel, int order,
            std::span<float> out);

}  // namespace atrium
