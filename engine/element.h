// Elements: the nodes of a patch's tree. A patch is the root; a node is split in two along a
// contact line that crosses it or, where none does, through its centroid, so that each half keeps
// at least 4/9 of the area [Winternitz]. Irradiance E is the one unknown of an element, given by
// its coefficients in an orthonormal polynomial basis of the element (solver/basis.h); radiosity
// follows as B = M + ρE. [THFH94 §4, GSCH93]
//
// These are the plain structs that cluster records hold byte for byte (engine/cluster_record.h):
// trivially copyable, no padding that is not named, indices and never pointers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "engine/geometry.h"
#include "engine/spectrum.h"

namespace atrium {

inline constexpr int kChannels = 3;
inline constexpr int kMaxOrder = 3;  // highest basis order built
// Coefficients a channel: polynomials of total degree < order over the plane.
constexpr int coefficient_count(int order) { return order * (order + 1) / 2; }
// The basis itself: the lower triangle that makes it from monomials (solver/basis.h).
constexpr int triangle_count(int order) {
  return coefficient_count(order) * (coefficient_count(order) + 1) / 2;
}
inline constexpr int kMaxCoefficients = coefficient_count(kMaxOrder);

// An element's outline has at most this many corners; a split that would exceed it is not made.
inline constexpr std::uint32_t kMaxOutline = 24;

// The places of a patch are its halves, their halves, and so on, kPlaceDepth times, numbered as in
// a heap: the patch is 1, the halves of place p are 2p and 2p + 1.
inline constexpr int kPlaceDepth = 6;
inline constexpr std::uint16_t kFirstDeepest = 1 << kPlaceDepth;

struct Element {
  double area = 0;     // m²
  Vec2 centroid{0};    // in the patch's frame
  double radius = 0;   // m, of the smallest circle about the centroid that holds the element
  double detail = 0;   // lm/m², root mean square of E's luminance that only the children hold
  // √ of the share of area beyond the contact line that crosses it, or that contacts within it may
  // close off, 0 if there are none: what a jump of one there leaves, root mean square, if it is not
  // seen.
  double crossing = 0;
  std::int32_t child = -1;   // the first of two, patch-local; -1: a leaf
  std::int32_t parent = -1;  // patch-local; -1: the root
  std::uint32_t first_vertex = 0;  // patch-local
  std::uint16_t vertex_count = 0;  // convex, counter-clockwise
  std::uint16_t place = 1;         // that it is, or is within
  bool leaf() const { return child < 0; }
};
static_assert(std::is_trivially_copyable_v<Element> && sizeof(Element) == 64);

// The one of a patch's first places, so many and the 0 that is none, that holds a place.
inline std::size_t place_among(std::size_t places, std::size_t place) {
  while (place >= places) place /= 2;
  return place;
}

// A contact line in the patch's frame: radiosity may jump across it.
struct Segment2 {
  Vec2 a{0}, b{0};
};

// What a patch's tree stands on.
struct PatchHead {
  Frame frame;           // u, v in the patch's plane, n towards the lit side
  Spectrum reflectance{0};
  Spectrum exitance{0};  // M, lm/m²
  double area = 0;       // m²
  double escape = -1;    // share of its cosine-weighted directions that leave the scene; -1: not measured
  std::uint32_t patch = 0;    // PatchId in the model
  std::uint32_t inert = 0;    // 1: blocks and absorbs only
  std::uint32_t first_element = 0, element_count = 0;  // into the cluster's arrays
  std::uint32_t first_vertex = 0, vertex_count = 0;
  std::uint32_t first_contact = 0, contact_count = 0;
};
static_assert(std::is_trivially_copyable_v<PatchHead> && sizeof(PatchHead) == 192);

}  // namespace atrium
