#include "engine/import/topology.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace atrium {
namespace {

bool before(const DirectedEdge& x, const DirectedEdge& y) {
  return std::tie(x.a, x.b, x.face) < std::tie(y.a, y.b, y.face);
}

// The corners of open edges, sorted along each axis, to be found near an edge.
class OpenCorners {
 public:
  OpenCorners(const Mesh& mesh, const EdgeTable& edges) : mesh_(mesh) {
    std::vector<std::uint32_t> corners;
    for (const DirectedEdge& e : edges.all())
      if (edges.find(e.b, e.a).empty()) {
        corners.push_back(e.a);
        corners.push_back(e.b);
      }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    for (int k = 0; k < 3; ++k) {
      std::vector<std::uint32_t>& sorted = sorted_[static_cast<std::size_t>(k)];
      sorted = corners;
      std::sort(sorted.begin(), sorted.end(), [&](std::uint32_t i, std::uint32_t j) {
        return std::pair(mesh_.vertices[i][k], i) < std::pair(mesh_.vertices[j][k], j);
      });
    }
  }

  // Appends the corners strictly within the edge from a to b, in order along it.
  void within(std::uint32_t a, std::uint32_t b, Ring& out) {
    const Vec3 &p = mesh_.vertices[a], &q = mesh_.vertices[b];
    const Vec3 d = q - p;
    const double l = length(d), tolerance = mesh_.tolerance;
    found_.clear();
    for (const std::uint32_t v : near(p, q)) {
      const Vec3 r = mesh_.vertices[v] - p;
      const double t = dot(r, d) / l;
      if (t > tolerance && t < l - tolerance && length(r - d * (t / l)) <= tolerance)
        found_.push_back({t, v});
    }
    std::sort(found_.begin(), found_.end());
    for (const auto& [t, v] : found_) out.push_back(v);
  }

 private:
  // The corners in the edge's slab along the axis where they are fewest.
  std::span<const std::uint32_t> near(const Vec3& p, const Vec3& q) const {
    std::span<const std::uint32_t> best = sorted_[0];
    for (int k = 0; k < 3; ++k) {
      const std::vector<std::uint32_t>& sorted = sorted_[static_cast<std::size_t>(k)];
      const double lo = std::min(p[k], q[k]) - mesh_.tolerance;
      const double hi = std::max(p[k], q[k]) + mesh_.tolerance;
      const auto first = std::partition_point(
          sorted.begin(), sorted.end(), [&](std::uint32_t v) { return mesh_.vertices[v][k] < lo; });
      const auto last = std::partition_point(
          first, sorted.end(), [&](std::uint32_t v) { return mesh_.vertices[v][k] <= hi; });
      const std::span<const std::uint32_t> slab(first, last);
      if (slab.size() < best.size()) best = slab;
    }
    return best;
  }

  const Mesh& mesh_;
  std::array<std::vector<std::uint32_t>, 3> sorted_;
  std::vector<std::pair<double, std::uint32_t>> found_;
};

}  // namespace

EdgeTable::EdgeTable(std::span<const std::uint32_t> faces, const std::vector<Ring>& rings) {
  for (const std::uint32_t f : faces) {
    const Ring& ring = rings[f];
    for (std::size_t i = 0; i < ring.size(); ++i)
      edges_.push_back({ring[i], ring[(i + 1) % ring.size()], f});
  }
  std::sort(edges_.begin(), edges_.end(), before);
}

std::span<const DirectedEdge> EdgeTable::find(std::uint32_t a, std::uint32_t b) const {
  const auto first = std::lower_bound(edges_.begin(), edges_.end(), DirectedEdge{a, b, 0}, before);
  auto last = first;
  while (last != edges_.end() && last->a == a && last->b == b) ++last;
  return {first, last};
}

void enter_junctions(const Mesh& mesh, std::span<const std::uint32_t> faces,
                     std::vector<Ring>& rings) {
  const EdgeTable edges(faces, rings);
  OpenCorners corners(mesh, edges);
  Ring entered;
  for (const std::uint32_t f : faces) {
    const Ring& ring = rings[f];
    entered.clear();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::uint32_t a = ring[i], b = ring[(i + 1) % ring.size()];
      entered.push_back(a);
      if (edges.find(b, a).empty()) corners.within(a, b, entered);
    }
    // A corner near two edges of one narrow ring would pinch it: that ring stays as it is.
    if (entered.size() > ring.size() && !names_a_vertex_twice(entered)) rings[f] = entered;
  }
}

std::vector<Ring> rings_of(const Mesh& mesh) {
  std::vector<Ring> rings;
  rings.reserve(mesh.faces.size());
  for (const Face& f : mesh.faces) {
    const auto corners = mesh.corners_of(f);
    rings.emplace_back(corners.begin(), corners.end());
  }
  return rings;
}

std::vector<std::vector<std::uint32_t>> faces_by_object(const Mesh& mesh, std::size_t objects) {
  std::vector<std::vector<std::uint32_t>> faces(objects);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    faces[mesh.faces[f].object.value].push_back(static_cast<std::uint32_t>(f));
  return faces;
}

std::vector<std::uint32_t> components(std::span<const std::uint32_t> faces,
                                      const EdgeTable& edges) {
  std::vector<std::uint32_t> parent(faces.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  std::unordered_map<std::uint32_t, std::uint32_t> number;  // of a face in `faces`
  for (std::size_t i = 0; i < faces.size(); ++i) number[faces[i]] = static_cast<std::uint32_t>(i);
  const DirectedEdge* previous = nullptr;
  for (const DirectedEdge& e : edges.all()) {
    if (previous && previous->a == e.a && previous->b == e.b)
      parent[root(number[e.face])] = root(number[previous->face]);
    previous = &e;
    const auto back = edges.find(e.b, e.a);
    if (!back.empty()) parent[root(number[e.face])] = root(number[back.front().face]);
  }
  std::vector<std::uint32_t> component(faces.size());
  std::unordered_map<std::uint32_t, std::uint32_t> names;
  for (std::size_t i = 0; i < faces.size(); ++i)
    component[i] = names
                       .try_emplace(root(static_cast<std::uint32_t>(i)),
                                    static_cast<std::uint32_t>(names.size()))
                       .first->second;
  return component;
}

std::vector<bool> balanced(std::span<const std::uint32_t> faces,
                           std::span<const std::uint32_t> component, const EdgeTable& edges) {
  std::unordered_map<std::uint32_t, std::uint32_t> component_of;
  std::uint32_t count = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    component_of[faces[i]] = component[i];
    count = std::max(count, component[i] + 1);
  }
  std::vector<bool> result(count, true);
  for (const DirectedEdge& e : edges.all())
    if (edges.find(e.a, e.b).size() != edges.find(e.b, e.a).size())
      result[component_of[e.face]] = false;
  return result;
}

}  // namespace atrium
