// Which faces meet at which edges. Solids of building models meet in T-junctions: one face's corner
// lies within another's edge. Entered into that edge, the corners make the two share edges.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/import/convex_pieces.h"
#include "engine/import/mesh.h"

namespace atrium {

struct DirectedEdge {
  std::uint32_t a = 0, b = 0;
  std::uint32_t face = 0;
};

// The directed edges of some faces' rings, sorted by (a, b).
class EdgeTable {
 public:
  EdgeTable(std::span<const std::uint32_t> faces, const std::vector<Ring>& rings);
  std::span<const DirectedEdge> find(std::uint32_t a, std::uint32_t b) const;
  std::span<const DirectedEdge> all() const { return edges_; }

 private:
  std::vector<DirectedEdge> edges_;
};

// Enters into the open edges of the faces' rings the corners of other open edges that lie on them.
void enter_junctions(const Mesh& mesh, std::span<const std::uint32_t> faces,
                     std::vector<Ring>& rings);

// The faces' rings as they are in the mesh.
std::vector<Ring> rings_of(const Mesh& mesh);

// The mesh's faces by object.
std::vector<std::vector<std::uint32_t>> faces_by_object(const Mesh& mesh, std::size_t objects);

// Components of faces joined by edges: the number of each face's component, in order of first
// faces.
std::vector<std::uint32_t> components(std::span<const std::uint32_t> faces, const EdgeTable& edges);

// By component: does every edge run as often one way as the other? Then it is a closed shell.
std::vector<bool> balanced(std::span<const std::uint32_t> faces,
                           std::span<const std::uint32_t> component, const EdgeTable& edges);

}  // namespace atrium
