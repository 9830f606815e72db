#include "engine/import/rejoin.h"

// OpenMesh fills new entries with default points, which it leaves uninitialized; seen only under
// the sanitizers.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <OpenMesh/Core/Mesh/PolyMesh_ArrayKernelT.hh>
#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "engine/import/ears.h"
#include "engine/import/plane_pieces.h"
#include "engine/import/topology.h"

namespace atrium {
namespace {

// Of the tolerance: how far a face may lie off its region's plane, so that pieces are planar
// within the whole of it.
constexpr double kPlaneShare = 0.5;
// Of the tolerance: what does not count as a corner of an outline; the later ones are for outlines
// whose area would suffer from the first.
constexpr double kCornerShares[] = {1, 0.1, 0.01};
// Cosine of the angle up to which narrow faces count as facing the same way.
constexpr double kSameWay = 0.9;

using HalfEdgeMesh = OpenMesh::PolyMesh_ArrayKernelT<>;  // topology alone: positions stay ours

// A region of faces as half-edges, and its outlines, interior on the left. Faces that OpenMesh
// refuses, for they would make the region fold over itself, are named in outside().
class Region {
 public:
  Region(std::vector<std::uint32_t> faces, const std::vector<Ring>& rings) {
    // A refused face leaves the mesh half changed: it is made anew without that one.
    for (auto refused = add_all(faces, rings); refused != faces.end();
         refused = add_all(faces, rings)) {
      outside_.push_back(*refused);
      faces.erase(refused);
    }
  }

  const std::vector<std::uint32_t>& outside() const { return outside_; }

  std::vector<Ring> outlines() const {
    std::vector<Ring> loops;
    std::vector<char> walked(mesh_.n_halfedges(), 0);
    for (const auto start : mesh_.halfedges()) {
      if (!on_outline(start) || walked[index(start)]) continue;
      Ring& loop = loops.emplace_back();
      for (HalfEdgeMesh::HalfedgeHandle h = start; !walked[index(h)]; h = onward(h)) {
        walked[index(h)] = 1;
        loop.push_back(vertices_[static_cast<std::size_t>(mesh_.from_vertex_handle(h).idx())]);
      }
    }
    return loops;
  }

 private:
  // The first face refused, or the end.
  std::vector<std::uint32_t>::iterator add_all(std::vector<std::uint32_t>& faces,
                                               const std::vector<Ring>& rings) {
    mesh_.clear();
    vertices_.clear();
    std::unordered_map<std::uint32_t, HalfEdgeMesh::VertexHandle> handles;
    std::vector<HalfEdgeMesh::VertexHandle> corners;
    for (auto f = faces.begin(); f != faces.end(); ++f) {
      corners.clear();
      for (const std::uint32_t v : rings[*f]) {
        const auto [at, added] = handles.try_emplace(v);
        if (added) {
          at->second = mesh_.add_vertex(HalfEdgeMesh::Point(0, 0, 0));
          vertices_.push_back(v);
        }
        corners.push_back(at->second);
      }
      if (!mesh_.add_face(corners).is_valid()) return f;
    }
    return faces.end();
  }

  static std::size_t index(HalfEdgeMesh::HalfedgeHandle h) {
    return static_cast<std::size_t>(h.idx());
  }
  bool on_outline(HalfEdgeMesh::HalfedgeHandle h) const {
    return !mesh_.is_boundary(h) && mesh_.is_boundary(mesh_.opposite_halfedge_handle(h));
  }
  // Round the vertex through the region to the next half-edge with nothing on its right.
  HalfEdgeMesh::HalfedgeHandle onward(HalfEdgeMesh::HalfedgeHandle h) const {
    h = mesh_.next_halfedge_handle(h);
    while (!on_outline(h)) h = mesh_.next_halfedge_handle(mesh_.opposite_halfedge_handle(h));
    return h;
  }

  HalfEdgeMesh mesh_;
  std::vector<std::uint32_t> vertices_;  // of the handles
  std::vector<std::uint32_t> outside_;
};

class Rejoiner {
 public:
  Rejoiner(Mesh& mesh, const std::vector<Ring>& rings, const RawModel& model, WarningLog& warnings)
      : mesh_(mesh), rings_(rings), model_(model), warnings_(warnings) {}

  std::vector<PatchRing> rejoin() {
    // OpenMesh says on its own stream what it refuses; here that is counted instead.
    omerr().disable();
    taken_.assign(mesh_.faces.size(), 0);
    for (const std::vector<std::uint32_t>& faces : faces_by_object(mesh_, model_.objects.size()))
      if (!faces.empty()) object(faces);
    omerr().enable();
    std::stable_sort(patches_.begin(), patches_.end(), [](const PatchRing& a, const PatchRing& b) {
      return std::pair(a.object, a.raw) < std::pair(b.object, b.raw);
    });
    return std::move(patches_);
  }

 private:
  void object(std::span<const std::uint32_t> faces) {
    const EdgeTable edges(faces, rings_);
    // Regions grow from the largest faces: those know their planes best.
    std::vector<std::uint32_t> seeds(faces.begin(), faces.end());
    std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
      return mesh_.faces[a].area > mesh_.faces[b].area;
    });
    for (const std::uint32_t seed : seeds)
      if (!taken_[seed]) region(grown(seed, edges));
  }

  // The faces that join the seed over shared edges in its plane.
  std::vector<std::uint32_t> grown(std::uint32_t seed, const EdgeTable& edges) {
    std::vector<std::uint32_t> faces{seed};
    taken_[seed] = 1;
    for (std::size_t i = 0; i < faces.size(); ++i) {
      const Ring& ring = rings_[faces[i]];
      for (std::size_t k = 0; k < ring.size(); ++k)
        for (const DirectedEdge& e : edges.find(ring[(k + 1) % ring.size()], ring[k]))
          if (!taken_[e.face] && joins(mesh_.faces[seed], mesh_.faces[e.face])) {
            taken_[e.face] = 1;
            faces.push_back(e.face);
          }
    }
    std::sort(faces.begin(), faces.end());
    return faces;
  }

  bool joins(const Face& seed, const Face& f) const {
    if (f.material != seed.material || f.sides != seed.sides) return false;
    if (dot(f.plane.normal, seed.plane.normal) < kSameWay) return false;
    for (const std::uint32_t v : mesh_.corners_of(f))
      if (std::abs(seed.plane.distance(mesh_.vertices[v])) > kPlaneShare * mesh_.tolerance)
        return false;
    return true;
  }

  void region(const std::vector<std::uint32_t>& faces) {
    if (faces.size() > 1) {
      const std::size_t vertices = mesh_.vertices.size();
      const Region joined(faces, rings_);
      const std::vector<std::uint32_t>& outside = joined.outside();
      if (outside.size() + 1 < faces.size() && join(faces, joined.outlines(), outside)) {
        for (const std::uint32_t f : outside) {
          warnings_.add("faces that fold over others of their plane, not rejoined",
                        model_.describe(model_.faces[mesh_.faces[f].raw]));
          alone(f);
        }
        return;
      }
      mesh_.vertices.resize(vertices);
    }
    for (const std::uint32_t f : faces) alone(f);
  }

  // Adds the region's own pieces if they are fewer than its faces'.
  bool join(const std::vector<std::uint32_t>& faces, const std::vector<Ring>& outlines,
            const std::vector<std::uint32_t>& outside) {
    double area = 0;
    std::size_t pieces_before = 0;
    std::uint32_t largest = faces[0], first = faces[0];
    for (const std::uint32_t f : faces) {
      if (std::find(outside.begin(), outside.end(), f) != outside.end()) continue;
      area += mesh_.faces[f].area;
      pieces_before += pieces_of(mesh_.faces[f]).size();
      if (mesh_.faces[f].area > mesh_.faces[largest].area) largest = f;
      if (mesh_.faces[f].raw < mesh_.faces[first].raw) first = f;
    }
    const Face& seed = mesh_.faces[largest];
    const Frame frame = frame_for(seed.plane, mesh_.polygon(mesh_.corners_of(seed), scratch_));
    for (const double share : kCornerShares) {
      const auto pieces = convex_pieces_in_space(mesh_.vertices, outlines, frame,
                                                 share * mesh_.tolerance, kAreaSlack * area);
      if (!pieces) continue;
      if (pieces->size() >= pieces_before) return false;
      if (!sound(*pieces, area)) continue;
      for (const Ring& piece : *pieces) add(piece, mesh_.faces[first]);
      return true;
    }
    warnings_.add("coplanar faces left as they are, for rejoining would change their area",
                  model_.describe(model_.faces[mesh_.faces[first].raw]), faces.size());
    return false;
  }

  // Do the pieces cover the area, each of them planar and more than a line?
  bool sound(const std::vector<Ring>& pieces, double area_before) {
    double covered = 0;
    for (const Ring& piece : pieces) {
      mesh_.polygon(piece, scratch_);
      if (planarity(scratch_) > mesh_.tolerance) return false;
      covered += area(scratch_);
    }
    return std::abs(covered - area_before) <= kAreaSlack * area_before;
  }

  // A face by itself in convex pieces of its own corners.
  std::vector<Ring> pieces_of(const Face& f) {
    const auto corners = mesh_.corners_of(f);
    const Ring ring(corners.begin(), corners.end());
    if (ring.size() == 3) return {ring};
    Polygon polygon;
    const Frame frame = frame_for(f.plane, mesh_.polygon(ring, polygon));
    for (const double share : kCornerShares) {
      auto pieces = convex_pieces_in_space(mesh_.vertices, std::span(&ring, 1), frame,
                                           share * mesh_.tolerance, kAreaSlack * f.area);
      if (pieces && sound(*pieces, f.area)) return std::move(*pieces);
    }
    std::vector<Ring> triangles;
    for (const auto& ear : clip_ears(polygon))
      triangles.push_back({ring[ear[0]], ring[ear[1]], ring[ear[2]]});
    return triangles;
  }

  void alone(std::uint32_t index) {
    const Face f = mesh_.faces[index];
    for (const Ring& piece : pieces_of(f)) add(piece, f);
  }

  void add(const Ring& piece, const Face& like) {
    if (width(mesh_.polygon(piece, scratch_)) <= mesh_.tolerance) {
      warnings_.add("slivers of cut faces dropped", model_.describe(model_.faces[like.raw]));
      return;
    }
    patches_.push_back({piece, like.object, like.material, like.sides, like.raw});
  }

  Mesh& mesh_;
  const std::vector<Ring>& rings_;
  const RawModel& model_;
  WarningLog& warnings_;
  std::vector<char> taken_;  // by face
  std::vector<PatchRing> patches_;
  Polygon scratch_;
};

}  // namespace

std::vector<PatchRing> rejoin(Mesh& mesh, const std::vector<Ring>& rings, const RawModel& model,
                              WarningLog& warnings) {
  return Rejoiner(mesh, rings, model, warnings).rejoin();
}

}  // namespace atrium
