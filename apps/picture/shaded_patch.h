// Shaded patches: what Gouraud shading needs of a cluster's element trees. Each leaf is a face
// whose outline holds, beside its own corners, those of finer neighbours on its edges, so that
// colours agree along every edge and no crack shows. A corner's colour is the mean of the
// polynomials of the leaves that meet there; leaves on different sides of a contact line keep their
// own. Patches of one plane and one paint are one sheet: neighbours across their rims count as
// neighbours inside do. [THFH94 §5.3, plate II]
//
// Invariants:
//  1. Radiosity is never negative: where a polynomial rings below zero it is clamped first.
//  2. Faces are the tree's leaves in its order; equal trees give equal bytes.
// Immutable once made; safe to read from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/cluster_record.h"

namespace atrium {

struct ShadedCorner {
  Vec2 p{0};              // in the sheet's frame
  Spectrum radiosity{0};  // lm/m²
};

struct ShadedFace {
  std::uint32_t first = 0, count = 0;  // its outline, into ShadedPatch::outline
  std::uint32_t own = 0;               // how many of these are the leaf's own corners
  std::uint32_t element = 0;           // the leaf
  ShadedCorner center;                 // centroid, the leaf's own mean there
};

// An inner node of the tree: which half of it a point lies in.
struct ShadedBranch {
  Vec2 normal{0};
  double offset = 0;
  // Where the normal points from, and to: a branch, or ~face.
  std::array<std::int32_t, 2> child{};
};

struct ShadedPatch {
  Frame frame;  // the sheet's: points are given in it
  bool emits = false;
  std::int32_t root = ~0;  // a branch, or ~face
  std::vector<ShadedBranch> branches;
  std::vector<ShadedFace> faces;
  std::vector<std::uint32_t> outline;  // indices of corners, counter-clockwise
  std::vector<ShadedCorner> corners;

  std::span<const std::uint32_t> outline_of(const ShadedFace& f) const {
    return std::span(outline).subspan(f.first, f.count);
  }
};

// One for each patch of the cluster. tolerance: m; corners nearer than it to one another or to an
// edge meet there.
std::vector<ShadedPatch> shade(const ClusterView& cluster, double tolerance);

std::size_t face_at(const ShadedPatch& patch, const Vec2& p);
// Interpolated over the face's outline by mean value coordinates. [Floater 2003]
Spectrum radiosity_at(const ShadedPatch& patch, const ShadedFace& face, const Vec2& p);

// The face cut in triangles, as indices of corners; `corners.size() + face` stands for the face's
// centre, which only faces with finer neighbours use.
void append_triangles(const ShadedPatch& patch, std::size_t face,
                      std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace atrium
