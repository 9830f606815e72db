// Model: the scene partitioned for the solve. Cells and portals divide space; a patch is one side
// of a piece of a surface that faces lit space; a cluster is what one object shows to one room;
// and for each cluster the global oracle lists the clusters it may see. [THFH94 §5]
//
// Invariants:
//  1. Patches of a cluster are contiguous, clusters keep the modeller's order (object, then room).
//  2. Every patch borders at least one cell that light can reach; what stands only in the dark is
//     not here (and cannot block either: no lit segment touches it).
//  3. `visible` is symmetric, sorted, and holds self-pairs where patches of a cluster may see each
//     other. It is conservative: never wrongly excludes, but for sight through closed gaps.
// Immutable once built; safe to read from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/geometry.h"
#include "engine/id.h"
#include "engine/scene.h"

namespace atrium {

// Rows of variable length in one array: row i is items[starts[i] .. starts[i+1]).
template <class T>
struct Rows {
  std::vector<std::uint32_t> starts{0};
  std::vector<T> items;
  std::size_t size() const { return starts.size() - 1; }
  std::span<const T> operator[](std::size_t i) const {
    return std::span(items).subspan(starts[i], starts[i + 1] - starts[i]);
  }
  void push_row(std::span<const T> row) {
    items.insert(items.end(), row.begin(), row.end());
    starts.push_back(static_cast<std::uint32_t>(items.size()));
  }
};

// A patch has at most this many corners (a disc's outline is cut in parts).
inline constexpr std::uint32_t kMaxPatchVertices = 16;

struct Patch {
  SurfaceId surface;
  MaterialId material;
  ClusterId cluster;
  std::uint32_t first_vertex = 0, vertex_count = 0;  // counter-clockwise seen from the lit side
  std::uint8_t back = 0;   // 1: the surface's back
  std::uint8_t inert = 0;  // 1: the back of a one-sided surface, or dark within a solid: blocks
  std::uint8_t footprint = 0;  // 1: of something that stands on the surface: mostly dark
  std::uint8_t reserved = 0;   // no byte of it is by chance: models are kept and compared as bytes
};
static_assert(sizeof(Patch) == 24);

// Where another surface meets a patch's plane on its lit side, or ends close over it: radiosity may
// jump across it.
struct Contact {
  Vec3 a, b;  // in the patch's plane
};

struct Cluster {
  ObjectId object;
  std::uint32_t room = 0;  // the connected group of cells it faces
  Box bounds;
  std::uint32_t first_patch = 0, patch_count = 0;
};

struct Cell {
  Box bounds;
  std::uint32_t room = 0;
  bool lit = false;  // light can reach it through portals
  std::array<std::uint8_t, 3> reserved{};  // as Patch's
};
static_assert(sizeof(Cell) == 56);

struct Portal {
  CellId a, b;
  std::uint32_t first_vertex = 0, vertex_count = 0;  // convex, into Model::portal_vertices
  double area = 0;                                   // m², transparent
};

// An opening between cells so narrow that it was asked to count as closed.
struct ClosedGap {
  double width = 0, length = 0;   // m
  Vec3 at{0};                     // where it is widest
  std::vector<ObjectId> objects;  // around it: most of its rim first
  std::vector<Polygon> polygons;  // convex: the portals that it would have been
};

struct Model {
  std::vector<Vec3> vertices;
  std::vector<Patch> patches;
  std::vector<Cluster> clusters;
  Rows<Contact> contacts;  // a row a patch
  std::vector<Cell> cells;
  std::vector<Portal> portals;
  std::vector<Vec3> portal_vertices;
  Rows<CellId> cells_of_cluster;  // lit cells that the cluster's patches border
  Rows<ClusterId> visible;        // a row a cluster
  std::uint32_t rooms = 0;
  std::uint64_t dark_surfaces = 0;  // surfaces left out whole, for no light reaches them
  double tolerance = 0;
  std::vector<ClosedGap> closed_gaps;  // the widest first; a run does not keep them, its log does

  PolygonView polygon(const Patch& p) const {
    return std::span(vertices).subspan(p.first_vertex, p.vertex_count);
  }
};

}  // namespace atrium
